/**
 * Status and clock of the session.
 */
export type SessionRow = {
    /**
     * virtual seconds per second
     */
    speed: number;
    /**
     * s; duration of the scenario
     */
    duration_s: number;
    /**
     * ticks; ticks from this frame to the end of the log
     */
    behind_ticks: number;
    /**
     * changes when the parameters must be read again
     */
    params_version: number;
    /**
     * changes when time has jumped: discard everything drawn before
     */
    generation: number;
    /**
     * connected viewers
     */
    viewers: number;
};
/**
 * Time at which the frame was taken.
 */
export type ClockRow = {
    /**
     * us; the daemon's monotonic clock when the frame was taken
     */
    wall_us: number;
};
/**
 * Packets, results of inputs, corrections, steps.
 */
export type EventsRow = {
    /**
     * counts them
     */
    id: number;
    /**
     * type of the event; the types up to pong are packets by their message
     */
    type: number;
    /**
     * the player that sent, received or caused it
     */
    player: number;
    /**
     * fate of a packet
     */
    fate: number;
    /**
     * input result and applied state: 0 applied, 1 refused, 2 stale, 3 late, 4 undecodable; connection: its state; segment: 1 sent again, and segment, blocked: 2 to the server
     */
    outcome: number;
    /**
     * s; when it was sent or happened; blocked: when it was complete; negative: in the lobby before the game
     */
    begin_s: number;
    /**
     * s; when it arrives; begin_s for a lost packet; blocked: when it was handed over
     */
    end_s: number;
    /**
     * input: its sequence number; state, display: the server's tick of the snapshot
     */
    number: number;
    /**
     * correction: signed distance in m; input: first axis; applied state: x of the own entity
     */
    value: number;
    /**
     * input: the server's step that it is meant for; 0: applied with the step after its arrival, or not answered by snapshots
     */
    tick: number;
    /**
     * ms; input: from moving the controls to making it
     */
    device_ms: number;
    /**
     * ms; input: from making it to sending it
     */
    held_ms: number;
};
/**
 * The server's view, then each player's.
 */
export type ViewsRow = {
    /**
     * 0: the server; 1 + p: player p
     */
    view: number;
    /**
     * techniques that are on; underrun: the buffer is empty; stalled: waits for an input; person: controlled by a person
     */
    flags: number;
    /**
     * state of the player's connection; the server's own is playing
     */
    connection: number;
    /**
     * whether the server has the player connected
     */
    connected: boolean;
    /**
     * of the last sent input; for the server its step
     */
    input_seq: number;
    /**
     * of the last input that the server acknowledged
     */
    acked_seq: number;
    /**
     * unacknowledged inputs
     */
    unacked: number;
    /**
     * ms; configured one-way lag in both directions
     */
    lag_ms: number;
    /**
     * ms; age of the remote entities as drawn
     */
    view_age_ms: number;
    /**
     * m; own entity: drawn minus the server's present; prediction makes it lead, which is no error
     */
    own_lead_m: number;
    /**
     * m; remote entities: drawn minus the server's present, the largest, signed
     */
    remote_error_m: number;
    /**
     * ms; time of the newest snapshot minus render time
     */
    buffer_ms: number;
    /**
     * ticks; input slack of the last input at the server; negative: late; null: unknown
     */
    slack_ticks: number;
    /**
     * number of corrections of the own entity
     */
    corrections: number;
    /**
     * m; the last correction, signed
     */
    correction_m: number;
    /**
     * inputs that the server refused
     */
    refused: number;
    /**
     * position of render time between its two snapshots
     */
    alpha: number;
    /**
     * s; render time of the remote entities
     */
    render_time_s: number;
};
/**
 * The entities of each view, as drawn.
 */
export type EntitiesRow = {
    /**
     * index of the view
     */
    view: number;
    /**
     * index of the entity; those of the players come first
     */
    entity: number;
    /**
     * held: no newer data; active: a projectile in flight; unsettled: overlaps what it was pushed into; away: its player is not connected; unknown: the player's snapshots do not contain it
     */
    flags: number;
    /**
     * m; position
     */
    x: number;
    /**
     * m; position
     */
    y: number;
    /**
     * m/s; velocity
     */
    vx: number;
    /**
     * m/s; velocity
     */
    vy: number;
    /**
     * rad; orientation
     */
    angle: number;
    /**
     * rad/s; angular velocity
     */
    angular_velocity: number;
    /**
     * ms; view age
     */
    age_ms: number;
};
/**
 * The game's own values of each player.
 */
export type GameRow = {
    /**
     * whose
     */
    player: number;
    /**
     * index of its name in the hello's layout, game_values
     */
    index: number;
    /**
     * the value; null: none yet
     */
    value: number;
};
/**
 * Projectiles in flight, in a game with weapons.
 */
export type ShellsRow = {
    /**
     * index of the view
     */
    view: number;
    /**
     * whose
     */
    player: number;
    /**
     * running number of the player's projectiles
     */
    number: number;
    /**
     * s; since the start of its flight
     */
    flown_s: number;
    /**
     * m; position
     */
    x: number;
    /**
     * m; position
     */
    y: number;
    /**
     * m/s; velocity
     */
    vx: number;
    /**
     * m/s; velocity
     */
    vy: number;
    /**
     * m; position at the start
     */
    from_x: number;
    /**
     * m; position at the start
     */
    from_y: number;
    /**
     * m/s; velocity at the start
     */
    from_vx: number;
    /**
     * m/s; velocity at the start
     */
    from_vy: number;
};
/**
 * The interpolation buffer and the de-jitter buffer of each player's view.
 */
export type BuffersRow = {
    /**
     * index of the player
     */
    player: number;
    /**
     * newest: draws the newest snapshot; starved: held, the buffer is empty
     */
    state: number;
    /**
     * ms; interpolation delay in use; 0 when the newest snapshot is drawn
     */
    delay_ms: number;
    /**
     * ms; newest time that could be known, minus render time
     */
    behind_ms: number;
    /**
     * rate of render time
     */
    time_scale: number;
    /**
     * ms; delay of the de-jitter buffer in use; 0: off
     */
    dejitter_ms: number;
    /**
     * times that it ran empty
     */
    underruns: number;
    /**
     * times that it was too full
     */
    overruns: number;
    /**
     * packets too late for the de-jitter buffer
     */
    late: number;
    /**
     * s; render time
     */
    drawn_s: number;
};
/**
 * Sums over each player's view from the warm-up on; a mean is the difference of two sums divided by that of their counts.
 */
export type MeasuresRow = {
    /**
     * index of the player
     */
    player: number;
    /**
     * ms; present age of information
     */
    age_of_information_ms: number;
    /**
     * m; sum of the own timeline error over displays
     */
    own_timeline_error_sum_m: number;
    /**
     * ms; sum of the input latencies
     */
    input_latency_sum_ms: number;
    /**
     * displays in that sum
     */
    own_timeline_errors: number;
    /**
     * changes of controls in that sum
     */
    input_latencies: number;
    /**
     * changes of controls
     */
    input_changes: number;
    /**
     * those that were never applied
     */
    input_changes_lost: number;
    /**
     * displays with a visible correction
     */
    visible_corrections: number;
};
/**
 * Clients with worlds of their own (deterministic, rollback); no rows with other syncs.
 */
export type PeersRow = {
    /**
     * index of the player
     */
    player: number;
    /**
     * confirmed tick: all inputs up to it have arrived
     */
    confirmed: number;
    /**
     * tick that is drawn
     */
    tick: number;
    /**
     * the first that differs from the server's; -1: none
     */
    desync_tick: number;
    /**
     * bit p: waits for the input of player p
     */
    waiting: number;
    /**
     * number of waits
     */
    stalls: number;
    /**
     * s; total time of waits
     */
    stalled_s: number;
    /**
     * number of rollbacks
     */
    rollbacks: number;
    /**
     * resimulated ticks
     */
    rollback_ticks: number;
    /**
     * entity that differs; -1: the game's tail
     */
    desync_entity: number;
    /**
     * field of it that differs
     */
    desync_field: number;
    /**
     * m; present distance from the server's world
     */
    desync_m: number;
    /**
     * ulps; of that field at that tick
     */
    desync_ulps: number;
};
/**
 * The input history of reconciliation: the last 32 inputs of each player with reconciliation, oldest first.
 */
export type InputHistoryRow = {
    /**
     * index of the player
     */
    player: number;
    /**
     * its sequence number
     */
    seq: number;
    /**
     * its result
     */
    state: number;
    /**
     * s; when it was made
     */
    made_s: number;
    /**
     * m; own entity after it, as last predicted; null: not yet
     */
    predicted_x: number;
    /**
     * m; own entity in the snapshot that acknowledged it; null: unknown
     */
    server_x: number;
    /**
     * m; difference of both; null: one is unknown
     */
    correction_m: number;
};
/**
 * Snapshots in these buffers, at most 16 per buffer, from the one that is drawn on.
 */
export type BufferedRow = {
    /**
     * index of the player
     */
    player: number;
    /**
     * buffer
     */
    place: number;
    /**
     * the server's, of the snapshot
     */
    tick: number;
    /**
     * s; server time of the snapshot, when it was sent
     */
    time_s: number;
    /**
     * s; when it arrived
     */
    arrived_s: number;
    /**
     * s; when the de-jitter buffer plays it out
     */
    due_s: number;
};
/**
 * For each player the last shot of each weapon that the server judged, not older than 5 s.
 */
export type ShotsRow = {
    /**
     * index of the shooter
     */
    player: number;
    /**
     * weapon
     */
    weapon: number;
    /**
     * the server's step that it was meant for
     */
    tick: number;
    /**
     * clamped: to max_rewind_ms; view_time_rejected: the server did not believe the stated view age; behind_cover: the target was behind cover
     */
    flags: number;
    /**
     * s; when the button was pressed
     */
    pressed_s: number;
    /**
     * s; render time of the shooter's view
     */
    view_time_s: number;
    /**
     * s; the server's present when it judged the shot
     */
    evaluated_at_s: number;
    /**
     * s; server time of the bodies that the shot was judged against
     */
    rewound_to_s: number;
    /**
     * m; the muzzle at the press
     */
    x: number;
    /**
     * m; the muzzle at the press
     */
    y: number;
    /**
     * the aim, a unit vector
     */
    dx: number;
    /**
     * the aim, a unit vector
     */
    dy: number;
    /**
     * m; the muzzle at the server
     */
    server_x: number;
    /**
     * m; the muzzle at the server
     */
    server_y: number;
    /**
     * body hit in the shooter's view; -1: none; -2: not known yet
     */
    client_view_hit: number;
    /**
     * body hit in the server's present, without compensation
     */
    server_now_hit: number;
    /**
     * body hit by the server's policy
     */
    compensated_hit: number;
    /**
     * body hit on a network without delay
     */
    perfect_hit: number;
};
/**
 * The bodies at the times of these shots.
 */
export type ShotBodiesRow = {
    /**
     * index of the shooter
     */
    player: number;
    /**
     * weapon
     */
    weapon: number;
    /**
     * of the shot
     */
    tick: number;
    /**
     * index of its entity
     */
    body: number;
    /**
     * m; in the shooter's view, at view_time_s
     */
    seen_x: number;
    /**
     * m; in the shooter's view, at view_time_s
     */
    seen_y: number;
    /**
     * m; in the server's present, at evaluated_at_s
     */
    now_x: number;
    /**
     * m; in the server's present, at evaluated_at_s
     */
    now_y: number;
    /**
     * m; where the shot was judged, at rewound_to_s
     */
    looked_x: number;
    /**
     * m; where the shot was judged, at rewound_to_s
     */
    looked_y: number;
};
/**
 * Messages of each player by type, from the warm-up on; no row for a type of which there was none.
 */
export type TrafficRow = {
    /**
     * index of the player
     */
    player: number;
    /**
     * type; input, connect and ping go to the server, the others to the player
     */
    message: number;
    /**
     * messages sent
     */
    messages: number;
    /**
     * packets in which they were sent, repetitions included
     */
    packets: number;
    /**
     * B; payload
     */
    bytes: number;
    /**
     * B; the same on the wire: with all headers
     */
    wire_bytes: number;
};
/**
 * Losses of each player's links, from the warm-up on.
 */
export type LinksRow = {
    /**
     * index of the player
     */
    player: number;
    /**
     * messages on the link to the server; of a transport its packets
     */
    up_sent: number;
    /**
     * those that did not arrive completely, for any cause
     */
    up_lost: number;
    /**
     * the same on the link to the player
     */
    down_sent: number;
    /**
     * those that did not arrive completely, for any cause
     */
    down_lost: number;
    /**
     * B; acknowledgements of a transport to the server, on the wire
     */
    up_ack_bytes: number;
    /**
     * B; the same to the player
     */
    down_ack_bytes: number;
    /**
     * snapshots sent, where they contain some of the entities; else 0
     */
    snapshots: number;
    /**
     * those in which changed entities had no room
     */
    choked: number;
    /**
     * ms; round trip of the newest ping; null: none yet
     */
    ping_ms: number;
};
/**
 * Spectators, counted from the game's begin.
 */
export type SpectatorsRow = {
    /**
     * index of the spectator
     */
    spectator: number;
    /**
     * catching_up: makes two ticks at once; out: has fallen out, and waits for a whole world
     */
    state: number;
    /**
     * tick that it shows
     */
    tick: number;
    /**
     * ticks; ticks whose inputs it has and that it has not shown
     */
    buffered: number;
    /**
     * ms; age of what it shows: virtual time now less the time at which its sender made that tick; null: the game has not begun
     */
    age_ms: number;
    /**
     * ticks of its machine without inputs for a next tick
     */
    waits: number;
    /**
     * ticks that it made as second ones at once
     */
    catch_up: number;
    /**
     * times that it has fallen out
     */
    falls: number;
};
/**
 * The entities as each spectator shows them: those of spectator s are of view 1 + players + s.
 */
export type SpectatedRow = {
    /**
     * index of the view
     */
    view: number;
    /**
     * index of the entity; those of the players come first
     */
    entity: number;
    /**
     * held: no newer data; active: a projectile in flight; unsettled: overlaps what it was pushed into; away: its player is not connected; unknown: the player's snapshots do not contain it
     */
    flags: number;
    /**
     * m; position
     */
    x: number;
    /**
     * m; position
     */
    y: number;
    /**
     * m/s; velocity
     */
    vx: number;
    /**
     * m/s; velocity
     */
    vy: number;
    /**
     * rad; orientation
     */
    angle: number;
    /**
     * rad/s; angular velocity
     */
    angular_velocity: number;
    /**
     * ms; view age
     */
    age_ms: number;
};
/**
 * The solution, then each method.
 */
export type MotionRow = {
    /**
     * off: not run
     */
    status: number;
    /**
     * s; time of the last step
     */
    t_s: number;
    /**
     * present distance from the solution
     */
    error: number;
    /**
     * largest error so far
     */
    error_max: number;
    /**
     * energy minus that of the start, relative to it
     */
    energy_drift: number;
    /**
     * of the derivative
     */
    evaluations: number;
    /**
     * accepted steps
     */
    steps: number;
    /**
     * rejected steps
     */
    rejected: number;
    /**
     * the largest error, each component relative to its size
     */
    error_max_weighted: number;
};
/**
 * The components of their states.
 */
export type MotionStateRow = {
    /**
     * 0: the solution; 1 + i: method i
     */
    motion: number;
    /**
     * index of its name in the hello's layout
     */
    component: number;
    /**
     * the component of the state
     */
    value: number;
};
/**
 * The worlds side by side.
 */
export type WorldsRow = {
    /**
     * ok, or why it has stopped
     */
    status: number;
    /**
     * its contact solver
     */
    solver: number;
    /**
     * whether a person drags a body
     */
    dragging: boolean;
    /**
     * number in the world
     */
    bodies: number;
    /**
     * bodies that are stepped
     */
    awake: number;
    /**
     * overlapping bounding boxes
     */
    pairs: number;
    /**
     * pairs that touch
     */
    touching: number;
    /**
     * contact points
     */
    points: number;
    /**
     * pairs with contact recycling: the points of the step before
     */
    recycled: number;
    /**
     * pairs tested by the narrow phase
     */
    tested: number;
    /**
     * islands: groups of connected bodies
     */
    islands: number;
    /**
     * bodies that tunnelled
     */
    tunnelled: number;
    /**
     * total number of bodies that CCD stopped at their time of impact
     */
    stopped: number;
    /**
     * number in the world
     */
    joints: number;
    /**
     * J; kinetic and potential
     */
    energy: number;
    /**
     * J; at the start
     */
    energy_start: number;
    /**
     * J; kinetic energy
     */
    kinetic: number;
    /**
     * m; present largest penetration
     */
    penetration: number;
    /**
     * m; largest penetration so far
     */
    penetration_worst: number;
    /**
     * m; largest distance that a body of the scene has sunk
     */
    sag: number;
    /**
     * m; largest sideways distance of a body of the scene
     */
    drift: number;
    /**
     * rad; largest angle by which a body of the scene has turned
     */
    tilt: number;
    /**
     * m; largest joint error
     */
    joint_error: number;
    /**
     * m/s; of the fastest body
     */
    speed_max: number;
    /**
     * kg m/s; of all bodies
     */
    momentum_x: number;
    /**
     * kg m/s; of all bodies
     */
    momentum_y: number;
    /**
     * bodies with CCD in this step
     */
    swept: number;
    /**
     * bodies that can move
     */
    dynamic: number;
};
/**
 * Geometries of the shapes; equal ones once.
 */
export type GeometriesRow = {
    /**
     * link: of a chain
     */
    kind: number;
    /**
     * m; around its vertices
     */
    radius: number;
    /**
     * m; centre of its bounding circle
     */
    circle_x: number;
    /**
     * m; centre of its bounding circle
     */
    circle_y: number;
    /**
     * m; of that circle
     */
    circle_radius: number;
    /**
     * m; a corner of its oriented bounding box
     */
    obb_x0: number;
    /**
     * m; a corner of its oriented bounding box
     */
    obb_y0: number;
    /**
     * m; the next corner
     */
    obb_x1: number;
    /**
     * m; the next corner
     */
    obb_y1: number;
    /**
     * m; the next corner
     */
    obb_x2: number;
    /**
     * m; the next corner
     */
    obb_y2: number;
    /**
     * m; the last corner
     */
    obb_x3: number;
    /**
     * m; the last corner
     */
    obb_y3: number;
};
/**
 * Vertices of the geometries; of a link its two, then its ghosts.
 */
export type VerticesRow = {
    /**
     * index of the geometry
     */
    geometry: number;
    /**
     * m; from the centre of mass
     */
    x: number;
    /**
     * m; from the centre of mass
     */
    y: number;
};
/**
 * Shapes of all bodies, at most 65,535.
 */
export type ShapesRow = {
    /**
     * index of the world
     */
    world: number;
    /**
     * its body; from 1 on
     */
    body: number;
    /**
     * index of its geometry
     */
    geometry: number;
    /**
     * of its body
     */
    flags: number;
    /**
     * m; of the centre of mass
     */
    x: number;
    /**
     * m; of the centre of mass
     */
    y: number;
    /**
     * rad; orientation
     */
    angle: number;
    /**
     * m/s; velocity
     */
    vx: number;
    /**
     * m/s; velocity
     */
    vy: number;
    /**
     * rad/s; angular velocity
     */
    angular_velocity: number;
    /**
     * m; box of the broad phase, relative to x and y
     */
    left: number;
    /**
     * m; box of the broad phase, relative to x and y
     */
    bottom: number;
    /**
     * m; box of the broad phase, relative to x and y
     */
    right: number;
    /**
     * m; box of the broad phase, relative to x and y
     */
    top: number;
    /**
     * number of its body's island; 0: none
     */
    island: number;
};
/**
 * Pairs of overlapping boxes, at most 8,192.
 */
export type ContactsRow = {
    /**
     * index of the world
     */
    world: number;
    /**
     * a body
     */
    a: number;
    /**
     * the other body
     */
    b: number;
    /**
     * contact points; 0: only their boxes overlap
     */
    count: number;
    /**
     * contact recycling: whether the points are those of the step before
     */
    recycled: boolean;
    /**
     * normal, from a to b; null: they do not touch
     */
    nx: number;
    /**
     * normal, from a to b; null: they do not touch
     */
    ny: number;
    /**
     * m; the first point; null: there is none
     */
    x0: number;
    /**
     * m; the first point; null: there is none
     */
    y0: number;
    /**
     * m; separation there; negative: they overlap; null: there is none
     */
    separation0: number;
    /**
     * N s; normal impulse there; null: there is none
     */
    impulse0: number;
    /**
     * m; the second point; null: there is none
     */
    x1: number;
    /**
     * m; the second point; null: there is none
     */
    y1: number;
    /**
     * m; separation there; negative: they overlap; null: there is none
     */
    separation1: number;
    /**
     * N s; normal impulse there; null: there is none
     */
    impulse1: number;
};
/**
 * At most 8,192.
 */
export type JointsRow = {
    /**
     * index of the world
     */
    world: number;
    /**
     * a body
     */
    a: number;
    /**
     * the other body
     */
    b: number;
    /**
     * joint type
     */
    type: number;
    /**
     * m; anchor on a
     */
    ax: number;
    /**
     * m; anchor on a
     */
    ay: number;
    /**
     * m; anchor on b
     */
    bx: number;
    /**
     * m; anchor on b
     */
    by: number;
};
/**
 * Results of the bounding volumes, where they are compared.
 */
export type VolumesRow = {
    /**
     * index of the world
     */
    world: number;
    /**
     * which
     */
    volume: number;
    /**
     * tests of pairs of shapes, over all steps
     */
    tests: number;
    /**
     * pairs whose volumes overlap
     */
    hits: number;
    /**
     * hits whose shapes do not overlap
     */
    false_hits: number;
    /**
     * pairs whose shapes overlap but their volumes do not
     */
    missed_hits: number;
    /**
     * m; mean distance of the shapes at false hits; 0: no false hits
     */
    gap_mean: number;
    /**
     * m; the largest of these
     */
    gap_max: number;
};
/**
 * The fluids side by side.
 */
export type FluidRow = {
    /**
     * ok, or why it has stopped
     */
    status: number;
    /**
     * whether a person drags it
     */
    held: boolean;
    /**
     * ticks made
     */
    ticks: number;
};
/**
 * Numbers that the method and the scene measure.
 */
export type FluidNumbersRow = {
    /**
     * whose
     */
    fluid: number;
    /**
     * index of its name in the hello's layout
     */
    number: number;
    /**
     * the number; null: unknown
     */
    value: number;
};
/**
 * The displayed field of fluids that have one, row by row from the bottom.
 */
export type FieldRow = {
    /**
     * cells; in x
     */
    width: number;
    /**
     * cells; in y
     */
    height: number;
    /**
     * whose
     */
    fluid: number;
    /**
     * index in the hello's layout
     */
    layer: number;
    /**
     * value of a cell of 0
     */
    low: number;
    /**
     * value of a cell of 254; a cell of 255 has no fluid
     */
    high: number;
    /**
     * width x height cells
     */
    values: Uint8Array;
};
/**
 * Points of fluids that have them, layer by layer.
 */
export type PointsRow = {
    /**
     * whose
     */
    fluid: number;
    /**
     * index of the layer in the hello's layout, which names its columns in order
     */
    layer: number;
    /**
     * m; the first column
     */
    x: number;
    /**
     * m; the second column
     */
    y: number;
    /**
     * the third column; null: the layer has none
     */
    value: number;
    /**
     * the fourth column; null: the layer has none
     */
    value_2: number;
    /**
     * the fifth column; null: the layer has none
     */
    value_3: number;
};
/**
 * The rows of each record, by its name.
 */
export type Records = {
    session: SessionRow;
    clock: ClockRow;
    events: EventsRow[];
    views: ViewsRow[];
    entities: EntitiesRow[];
    game: GameRow[];
    shells: ShellsRow[];
    buffers: BuffersRow[];
    measures: MeasuresRow[];
    peers: PeersRow[];
    input_history: InputHistoryRow[];
    buffered: BufferedRow[];
    shots: ShotsRow[];
    shot_bodies: ShotBodiesRow[];
    traffic: TrafficRow[];
    links: LinksRow[];
    spectators: SpectatorsRow[];
    spectated: SpectatedRow[];
    motion: MotionRow[];
    motion_state: MotionStateRow[];
    worlds: WorldsRow[];
    geometries: GeometriesRow[];
    vertices: VerticesRow[];
    shapes: ShapesRow[];
    contacts: ContactsRow[];
    joints: JointsRow[];
    volumes: VolumesRow[];
    fluid: FluidRow[];
    fluid_numbers: FluidNumbersRow[];
    field: FieldRow[];
    points: PointsRow[];
};
