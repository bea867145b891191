# The rooms that make the engine: pure functions of scenario, seed and log, from the lowest up.
set(engine_rooms base threads memory param input record ode rigid fluid link game netcode sim session library)
