// Written by docs/generate.mjs from `laglab schema stream`: the tables are in C, and changed there.

/**
 * Status and clock of the session.
 * @typedef {object} SessionRow
 * @property {number} speed  virtual seconds per second
 * @property {number} duration_s  s; duration of the scenario
 * @property {number} behind_ticks  ticks; ticks from this frame to the end of the log
 * @property {number} params_version  changes when the parameters must be read again
 * @property {number} generation  changes when time has jumped: discard everything drawn before
 * @property {number} viewers  connected viewers
 */

/**
 * Time at which the frame was taken.
 * @typedef {object} ClockRow
 * @property {number} wall_us  us; the daemon's monotonic clock when the frame was taken
 */

/**
 * Packets, results of inputs, corrections, steps.
 * @typedef {object} EventsRow
 * @property {number} id  counts them
 * @property {number} type  type of the event; the types up to pong are packets by their message
 * @property {number} player  the player that sent, received or caused it
 * @property {number} fate  fate of a packet
 * @property {number} outcome  input result and applied state: 0 applied, 1 refused, 2 stale, 3 late, 4 undecodable; connection: its state; segment: 1 sent again, and segment, blocked: 2 to the server
 * @property {number} begin_s  s; when it was sent or happened; blocked: when it was complete; negative: in the lobby before the game
 * @property {number} end_s  s; when it arrives; begin_s for a lost packet; blocked: when it was handed over
 * @property {number} number  input: its sequence number; state, display: the server's tick of the snapshot
 * @property {number} value  correction: signed distance in m; input: first axis; applied state: x of the own entity
 * @property {number} tick  input: the server's step that it is meant for; 0: applied with the step after its arrival, or not answered by snapshots
 * @property {number} device_ms  ms; input: from moving the controls to making it
 * @property {number} held_ms  ms; input: from making it to sending it
 */

/**
 * The server's view, then each player's.
 * @typedef {object} ViewsRow
 * @property {number} view  0: the server; 1 + p: player p
 * @property {number} flags  techniques that are on; underrun: the buffer is empty; stalled: waits for an input; person: controlled by a person
 * @property {number} connection  state of the player's connection; the server's own is playing
 * @property {boolean} connected  whether the server has the player connected
 * @property {number} input_seq  of the last sent input; for the server its step
 * @property {number} acked_seq  of the last input that the server acknowledged
 * @property {number} unacked  unacknowledged inputs
 * @property {number} lag_ms  ms; configured one-way lag in both directions
 * @property {number} view_age_ms  ms; age of the remote entities as drawn
 * @property {number} own_lead_m  m; own entity: drawn minus the server's present; prediction makes it lead, which is no error
 * @property {number} remote_error_m  m; remote entities: drawn minus the server's present, the largest, signed
 * @property {number} buffer_ms  ms; time of the newest snapshot minus render time
 * @property {number} slack_ticks  ticks; input slack of the last input at the server; negative: late; null: unknown
 * @property {number} corrections  number of corrections of the own entity
 * @property {number} correction_m  m; the last correction, signed
 * @property {number} refused  inputs that the server refused
 * @property {number} alpha  position of render time between its two snapshots
 * @property {number} render_time_s  s; render time of the remote entities
 */

/**
 * The entities of each view, as drawn.
 * @typedef {object} EntitiesRow
 * @property {number} view  index of the view
 * @property {number} entity  index of the entity; those of the players come first
 * @property {number} flags  held: no newer data; active: a projectile in flight; unsettled: overlaps what it was pushed into; away: its player is not connected; unknown: the player's snapshots do not contain it
 * @property {number} x  m; position
 * @property {number} y  m; position
 * @property {number} vx  m/s; velocity
 * @property {number} vy  m/s; velocity
 * @property {number} angle  rad; orientation
 * @property {number} angular_velocity  rad/s; angular velocity
 * @property {number} age_ms  ms; view age
 */

/**
 * The game's own values of each player.
 * @typedef {object} GameRow
 * @property {number} player  whose
 * @property {number} index  index of its name in the hello's layout, game_values
 * @property {number} value  the value; null: none yet
 */

/**
 * Projectiles in flight, in a game with weapons.
 * @typedef {object} ShellsRow
 * @property {number} view  index of the view
 * @property {number} player  whose
 * @property {number} number  running number of the player's projectiles
 * @property {number} flown_s  s; since the start of its flight
 * @property {number} x  m; position
 * @property {number} y  m; position
 * @property {number} vx  m/s; velocity
 * @property {number} vy  m/s; velocity
 * @property {number} from_x  m; position at the start
 * @property {number} from_y  m; position at the start
 * @property {number} from_vx  m/s; velocity at the start
 * @property {number} from_vy  m/s; velocity at the start
 */

/**
 * The interpolation buffer and the de-jitter buffer of each player's view.
 * @typedef {object} BuffersRow
 * @property {number} player  index of the player
 * @property {number} state  newest: draws the newest snapshot; starved: held, the buffer is empty
 * @property {number} delay_ms  ms; interpolation delay in use; 0 when the newest snapshot is drawn
 * @property {number} behind_ms  ms; newest time that could be known, minus render time
 * @property {number} time_scale  rate of render time
 * @property {number} dejitter_ms  ms; delay of the de-jitter buffer in use; 0: off
 * @property {number} underruns  times that it ran empty
 * @property {number} overruns  times that it was too full
 * @property {number} late  packets too late for the de-jitter buffer
 * @property {number} drawn_s  s; render time
 */

/**
 * Sums over each player's view from the warm-up on; a mean is the difference of two sums divided by that of their counts.
 * @typedef {object} MeasuresRow
 * @property {number} player  index of the player
 * @property {number} age_of_information_ms  ms; present age of information
 * @property {number} own_timeline_error_sum_m  m; sum of the own timeline error over displays
 * @property {number} input_latency_sum_ms  ms; sum of the input latencies
 * @property {number} own_timeline_errors  displays in that sum
 * @property {number} input_latencies  changes of controls in that sum
 * @property {number} input_changes  changes of controls
 * @property {number} input_changes_lost  those that were never applied
 * @property {number} visible_corrections  displays with a visible correction
 */

/**
 * Clients with worlds of their own (deterministic, rollback); no rows with other syncs.
 * @typedef {object} PeersRow
 * @property {number} player  index of the player
 * @property {number} confirmed  confirmed tick: all inputs up to it have arrived
 * @property {number} tick  tick that is drawn
 * @property {number} desync_tick  the first that differs from the server's; -1: none
 * @property {number} waiting  bit p: waits for the input of player p
 * @property {number} stalls  number of waits
 * @property {number} stalled_s  s; total time of waits
 * @property {number} rollbacks  number of rollbacks
 * @property {number} rollback_ticks  resimulated ticks
 * @property {number} desync_entity  entity that differs; -1: the game's tail
 * @property {number} desync_field  field of it that differs
 * @property {number} desync_m  m; present distance from the server's world
 * @property {number} desync_ulps  ulps; of that field at that tick
 */

/**
 * The input history of reconciliation: the last 32 inputs of each player with reconciliation, oldest first.
 * @typedef {object} InputHistoryRow
 * @property {number} player  index of the player
 * @property {number} seq  its sequence number
 * @property {number} state  its result
 * @property {number} made_s  s; when it was made
 * @property {number} predicted_x  m; own entity after it, as last predicted; null: not yet
 * @property {number} server_x  m; own entity in the snapshot that acknowledged it; null: unknown
 * @property {number} correction_m  m; difference of both; null: one is unknown
 */

/**
 * Snapshots in these buffers, at most 16 per buffer, from the one that is drawn on.
 * @typedef {object} BufferedRow
 * @property {number} player  index of the player
 * @property {number} place  buffer
 * @property {number} tick  the server's, of the snapshot
 * @property {number} time_s  s; server time of the snapshot, when it was sent
 * @property {number} arrived_s  s; when it arrived
 * @property {number} due_s  s; when the de-jitter buffer plays it out
 */

/**
 * For each player the last shot of each weapon that the server judged, not older than 5 s.
 * @typedef {object} ShotsRow
 * @property {number} player  index of the shooter
 * @property {number} weapon  weapon
 * @property {number} tick  the server's step that it was meant for
 * @property {number} flags  clamped: to max_rewind_ms; view_time_rejected: the server did not believe the stated view age; behind_cover: the target was behind cover
 * @property {number} pressed_s  s; when the button was pressed
 * @property {number} view_time_s  s; render time of the shooter's view
 * @property {number} evaluated_at_s  s; the server's present when it judged the shot
 * @property {number} rewound_to_s  s; server time of the bodies that the shot was judged against
 * @property {number} x  m; the muzzle at the press
 * @property {number} y  m; the muzzle at the press
 * @property {number} dx  the aim, a unit vector
 * @property {number} dy  the aim, a unit vector
 * @property {number} server_x  m; the muzzle at the server
 * @property {number} server_y  m; the muzzle at the server
 * @property {number} client_view_hit  body hit in the shooter's view; -1: none; -2: not known yet
 * @property {number} server_now_hit  body hit in the server's present, without compensation
 * @property {number} compensated_hit  body hit by the server's policy
 * @property {number} perfect_hit  body hit on a network without delay
 */

/**
 * The bodies at the times of these shots.
 * @typedef {object} ShotBodiesRow
 * @property {number} player  index of the shooter
 * @property {number} weapon  weapon
 * @property {number} tick  of the shot
 * @property {number} body  index of its entity
 * @property {number} seen_x  m; in the shooter's view, at view_time_s
 * @property {number} seen_y  m; in the shooter's view, at view_time_s
 * @property {number} now_x  m; in the server's present, at evaluated_at_s
 * @property {number} now_y  m; in the server's present, at evaluated_at_s
 * @property {number} looked_x  m; where the shot was judged, at rewound_to_s
 * @property {number} looked_y  m; where the shot was judged, at rewound_to_s
 */

/**
 * Messages of each player by type, from the warm-up on; no row for a type of which there was none.
 * @typedef {object} TrafficRow
 * @property {number} player  index of the player
 * @property {number} message  type; input, connect and ping go to the server, the others to the player
 * @property {number} messages  messages sent
 * @property {number} packets  packets in which they were sent, repetitions included
 * @property {number} bytes  B; payload
 * @property {number} wire_bytes  B; the same on the wire: with all headers
 */

/**
 * Losses of each player's links, from the warm-up on.
 * @typedef {object} LinksRow
 * @property {number} player  index of the player
 * @property {number} up_sent  messages on the link to the server; of a transport its packets
 * @property {number} up_lost  those that did not arrive completely, for any cause
 * @property {number} down_sent  the same on the link to the player
 * @property {number} down_lost  those that did not arrive completely, for any cause
 * @property {number} up_ack_bytes  B; acknowledgements of a transport to the server, on the wire
 * @property {number} down_ack_bytes  B; the same to the player
 * @property {number} snapshots  snapshots sent, where they contain some of the entities; else 0
 * @property {number} choked  those in which changed entities had no room
 * @property {number} ping_ms  ms; round trip of the newest ping; null: none yet
 */

/**
 * The solution, then each method.
 * @typedef {object} MotionRow
 * @property {number} status  off: not run
 * @property {number} t_s  s; time of the last step
 * @property {number} error  present distance from the solution
 * @property {number} error_max  largest error so far
 * @property {number} energy_drift  energy minus that of the start, relative to it
 * @property {number} evaluations  of the derivative
 * @property {number} steps  accepted steps
 * @property {number} rejected  rejected steps
 * @property {number} error_max_weighted  the largest error, each component relative to its size
 */

/**
 * The components of their states.
 * @typedef {object} MotionStateRow
 * @property {number} motion  0: the solution; 1 + i: method i
 * @property {number} component  index of its name in the hello's layout
 * @property {number} value  the component of the state
 */

/**
 * The worlds side by side.
 * @typedef {object} WorldsRow
 * @property {number} status  ok, or why it has stopped
 * @property {number} solver  its contact solver
 * @property {boolean} dragging  whether a person drags a body
 * @property {number} bodies  number in the world
 * @property {number} awake  bodies that are stepped
 * @property {number} pairs  overlapping bounding boxes
 * @property {number} touching  pairs that touch
 * @property {number} points  contact points
 * @property {number} recycled  pairs with contact recycling: the points of the step before
 * @property {number} tested  pairs tested by the narrow phase
 * @property {number} islands  islands: groups of connected bodies
 * @property {number} tunnelled  bodies that tunnelled
 * @property {number} stopped  total number of bodies that CCD stopped at their time of impact
 * @property {number} joints  number in the world
 * @property {number} energy  J; kinetic and potential
 * @property {number} energy_start  J; at the start
 * @property {number} kinetic  J; kinetic energy
 * @property {number} penetration  m; present largest penetration
 * @property {number} penetration_worst  m; largest penetration so far
 * @property {number} sag  m; largest distance that a body of the scene has sunk
 * @property {number} drift  m; largest sideways distance of a body of the scene
 * @property {number} tilt  rad; largest angle by which a body of the scene has turned
 * @property {number} joint_error  m; largest joint error
 * @property {number} speed_max  m/s; of the fastest body
 * @property {number} momentum_x  kg m/s; of all bodies
 * @property {number} momentum_y  kg m/s; of all bodies
 * @property {number} swept  bodies with CCD in this step
 * @property {number} dynamic  bodies that can move
 */

/**
 * Geometries of the shapes; equal ones once.
 * @typedef {object} GeometriesRow
 * @property {number} kind  link: of a chain
 * @property {number} radius  m; around its vertices
 * @property {number} circle_x  m; centre of its bounding circle
 * @property {number} circle_y  m; centre of its bounding circle
 * @property {number} circle_radius  m; of that circle
 * @property {number} obb_x0  m; a corner of its oriented bounding box
 * @property {number} obb_y0  m; a corner of its oriented bounding box
 * @property {number} obb_x1  m; the next corner
 * @property {number} obb_y1  m; the next corner
 * @property {number} obb_x2  m; the next corner
 * @property {number} obb_y2  m; the next corner
 * @property {number} obb_x3  m; the last corner
 * @property {number} obb_y3  m; the last corner
 */

/**
 * Vertices of the geometries; of a link its two, then its ghosts.
 * @typedef {object} VerticesRow
 * @property {number} geometry  index of the geometry
 * @property {number} x  m; from the centre of mass
 * @property {number} y  m; from the centre of mass
 */

/**
 * Shapes of all bodies, at most 65,535.
 * @typedef {object} ShapesRow
 * @property {number} world  index of the world
 * @property {number} body  its body; from 1 on
 * @property {number} geometry  index of its geometry
 * @property {number} flags  of its body
 * @property {number} x  m; of the centre of mass
 * @property {number} y  m; of the centre of mass
 * @property {number} angle  rad; orientation
 * @property {number} vx  m/s; velocity
 * @property {number} vy  m/s; velocity
 * @property {number} angular_velocity  rad/s; angular velocity
 * @property {number} left  m; box of the broad phase, relative to x and y
 * @property {number} bottom  m; box of the broad phase, relative to x and y
 * @property {number} right  m; box of the broad phase, relative to x and y
 * @property {number} top  m; box of the broad phase, relative to x and y
 * @property {number} island  number of its body's island; 0: none
 */

/**
 * Pairs of overlapping boxes, at most 8,192.
 * @typedef {object} ContactsRow
 * @property {number} world  index of the world
 * @property {number} a  a body
 * @property {number} b  the other body
 * @property {number} count  contact points; 0: only their boxes overlap
 * @property {boolean} recycled  contact recycling: whether the points are those of the step before
 * @property {number} nx  normal, from a to b; null: they do not touch
 * @property {number} ny  normal, from a to b; null: they do not touch
 * @property {number} x0  m; the first point; null: there is none
 * @property {number} y0  m; the first point; null: there is none
 * @property {number} separation0  m; separation there; negative: they overlap; null: there is none
 * @property {number} impulse0  N s; normal impulse there; null: there is none
 * @property {number} x1  m; the second point; null: there is none
 * @property {number} y1  m; the second point; null: there is none
 * @property {number} separation1  m; separation there; negative: they overlap; null: there is none
 * @property {number} impulse1  N s; normal impulse there; null: there is none
 */

/**
 * At most 8,192.
 * @typedef {object} JointsRow
 * @property {number} world  index of the world
 * @property {number} a  a body
 * @property {number} b  the other body
 * @property {number} type  joint type
 * @property {number} ax  m; anchor on a
 * @property {number} ay  m; anchor on a
 * @property {number} bx  m; anchor on b
 * @property {number} by  m; anchor on b
 */

/**
 * Results of the bounding volumes, where they are compared.
 * @typedef {object} VolumesRow
 * @property {number} world  index of the world
 * @property {number} volume  which
 * @property {number} tests  tests of pairs of shapes, over all steps
 * @property {number} hits  pairs whose volumes overlap
 * @property {number} false_hits  hits whose shapes do not overlap
 * @property {number} missed_hits  pairs whose shapes overlap but their volumes do not
 * @property {number} gap_mean  m; mean distance of the shapes at false hits; 0: no false hits
 * @property {number} gap_max  m; the largest of these
 */

/**
 * The fluids side by side.
 * @typedef {object} FluidRow
 * @property {number} status  ok, or why it has stopped
 * @property {boolean} held  whether a person drags it
 * @property {number} ticks  ticks made
 */

/**
 * Numbers that the method and the scene measure.
 * @typedef {object} FluidNumbersRow
 * @property {number} fluid  whose
 * @property {number} number  index of its name in the hello's layout
 * @property {number} value  the number; null: unknown
 */

/**
 * The displayed field of fluids that have one, row by row from the bottom.
 * @typedef {object} FieldRow
 * @property {number} width  cells; in x
 * @property {number} height  cells; in y
 * @property {number} fluid  whose
 * @property {number} layer  index in the hello's layout
 * @property {number} low  value of a cell of 0
 * @property {number} high  value of a cell of 254; a cell of 255 has no fluid
 * @property {Uint8Array} values  width x height cells
 */

/**
 * Points of fluids that have them, layer by layer.
 * @typedef {object} PointsRow
 * @property {number} fluid  whose
 * @property {number} layer  index of the layer in the hello's layout, which names its columns in order
 * @property {number} x  m; the first column
 * @property {number} y  m; the second column
 * @property {number} value  the third column; null: the layer has none
 * @property {number} value_2  the fourth column; null: the layer has none
 * @property {number} value_3  the fifth column; null: the layer has none
 */

/**
 * The rows of each record, by its name.
 * @typedef {object} Records
 * @property {SessionRow} session
 * @property {ClockRow} clock
 * @property {EventsRow[]} events
 * @property {ViewsRow[]} views
 * @property {EntitiesRow[]} entities
 * @property {GameRow[]} game
 * @property {ShellsRow[]} shells
 * @property {BuffersRow[]} buffers
 * @property {MeasuresRow[]} measures
 * @property {PeersRow[]} peers
 * @property {InputHistoryRow[]} input_history
 * @property {BufferedRow[]} buffered
 * @property {ShotsRow[]} shots
 * @property {ShotBodiesRow[]} shot_bodies
 * @property {TrafficRow[]} traffic
 * @property {LinksRow[]} links
 * @property {MotionRow[]} motion
 * @property {MotionStateRow[]} motion_state
 * @property {WorldsRow[]} worlds
 * @property {GeometriesRow[]} geometries
 * @property {VerticesRow[]} vertices
 * @property {ShapesRow[]} shapes
 * @property {ContactsRow[]} contacts
 * @property {JointsRow[]} joints
 * @property {VolumesRow[]} volumes
 * @property {FluidRow[]} fluid
 * @property {FluidNumbersRow[]} fluid_numbers
 * @property {FieldRow[]} field
 * @property {PointsRow[]} points
 */

export {};
