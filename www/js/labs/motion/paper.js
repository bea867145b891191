// Where the paper says one thing and the lab shows another: the names of their texts, motion.paper_says and motion.lab_shows.

/** By the figure. @type {Record<string, string[]>} */
export const ERRATA = {
  'Figure 1': ['duration', 'thirtieth', 'listing'],
  'Figure 2': ['listing', 'order'],
  'Figure 3': ['listing', 'drift', 'digits'],
  'Figure 4': ['lost', 'listing'],
};

/** Methods that have one of their own name. */
export const METHOD_ERRATA = ['explicit_euler', 'stormer_verlet', 'verlet_as_printed', 'implicit_euler'];
