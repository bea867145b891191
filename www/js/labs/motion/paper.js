// What the paper says, and what the lab shows, where the two differ.

/** @typedef {{says: string, shows: string}} Erratum */

const LISTING = {
  says: 'The listing is explicit Euler.',
  shows:
    'It updates the velocity first and uses the new one: semi-implicit Euler, ahead of the truth by a t dt / 2. ' +
    'Explicit Euler is behind by as much.',
};
const ORDER = {
  says: 'Semi-implicit Euler errs by rounding in each step.',
  shows: 'It errs by truncation: the error is a t dt / 2 and halves with the step, at any precision.',
};

/** @type {Record<string, Erratum[]>} */
export const ERRATA = {
  'Figure 1': [
    { says: 'A timestep of 5 seconds.', shows: '5 s is the duration; the step is 0.033 s.' },
    { says: '33 ms, 1/30 of a second.', shows: '1/30 s is 33.33 ms: 151 steps of 0.033 s end at 4.983 s, not at 5 s.' },
    LISTING,
  ],
  'Figure 2': [LISTING, ORDER],
  'Figure 3': [
    LISTING,
    { says: 'With dt the displacement drifts.', shows: 'It is off by a t dt / 2: the error of order 1, linear in the step.' },
    {
      says: '25.200001, 32.400002, ...',
      shows: 'Single precision without fused multiply-add: a build with it prints other digits in the last four lines.',
    },
  ],
  'Figure 4': [
    {
      says: '52.00, 49.00, 46.00, 45.58',
      shows:
        '52.5, 49.5, 46.5 at 3 s, and 45.58554 at 3.003 s (the program of the paper, in single precision: 45.585541): ' +
        'digits are lost in print, and the last row is not at 3 s.',
    },
    LISTING,
  ],
};

/** @type {Record<string, Erratum>} by method */
export const METHOD_ERRATA = {
  explicit_euler: {
    says: 'Explicit Euler fails when the acceleration is no longer constant.',
    shows:
      'Its error is a t dt / 2 for a constant one already, and of order 1 for a varying one too. ' +
      'It fails on a swing: every step adds energy, however small it is.',
  },
  stormer_verlet: {
    says: 'An advantage of Verlet is reversibility.',
    shows:
      'In exact arithmetic and on a lattice of fixed point (verlet lattice), ' +
      'not to the bit in floating point; and with steps of constant length only.',
  },
  verlet_as_printed: {
    says: 's + v t + a t² / 2 with v = (s − s₋) / dt.',
    shows: 'That is 2 s − s₋ + a dt² / 2, which moves under half the acceleration: 22.5 m instead of 45 m. Right is + a dt².',
  },
  implicit_euler: {
    says: 'Implicit Euler is more accurate.',
    shows: 'Its error is as large as explicit Euler’s, of the other sign; what it has is stability, bought with damping.',
  },
};
