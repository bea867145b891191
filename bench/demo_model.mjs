// The rules of the live demo on which the paper's demo is based, written from their description and run on a virtual clock:
// no canvas, no DOM, no timers, nothing measured. What is left is what a browser computes to simulate it.
//
//   Client, 50 Hz: take what has arrived; on a state set the own entity to the server's place and re-apply the inputs that it does
//     not acknowledge (reconciliation), or drop them; others: buffer with the time of receipt (interpolation), or set. Then sample the
//     keys: while one is down, an input {press_time = +-dt, seq, entity} goes to the server and, with prediction, moves the own entity.
//     Then draw others one update interval ago, between the two samples around that time.
//   Server, at its update rate: take all inputs that have arrived, refuse |press_time| > 1/40 s, apply, remember the last one's number;
//     send all clients every entity's place and last processed input.
//   Network: a queue per direction; a message may be taken `lag` after it was sent.
import { pathToFileURL } from 'node:url';

const SPEED = 2;

class LagNetwork {
  messages = [];
  send(lag, now, payload) {
    this.messages.push({ due: now + lag, payload });
  }
  receive(now) {
    for (let i = 0; i < this.messages.length; i++) if (this.messages[i].due <= now) return this.messages.splice(i, 1)[0].payload;
  }
}

class Entity {
  constructor(id, x) {
    this.id = id;
    this.x = x;
    this.buffer = [];
  }
  apply(input) {
    this.x += input.press_time * SPEED;
  }
}

class Client {
  network = new LagNetwork();
  entities = new Map();
  pending = [];
  seq = 0;
  last = undefined;

  constructor(id, lag, { prediction, reconciliation, interpolation }) {
    Object.assign(this, { id, lag, prediction, reconciliation, interpolation });
  }

  update(now, server, key) {
    this.receive(now);
    const me = this.entities.get(this.id);
    if (me) {
      this.input(now, server, me, key);
      if (this.interpolation) this.interpolate(now, server.updateHz);
    }
  }

  receive(now) {
    for (let message; (message = this.network.receive(now)); ) {
      for (const state of message) {
        let entity = this.entities.get(state.entity);
        if (!entity) this.entities.set(state.entity, (entity = new Entity(state.entity, state.x)));
        if (state.entity === this.id) this.own(entity, state);
        else if (this.interpolation) entity.buffer.push({ time: now, x: state.x });
        else entity.x = state.x;
      }
    }
  }

  own(me, state) {
    me.x = state.x;
    if (!this.reconciliation) {
      this.pending = [];
      return;
    }
    for (let i = 0; i < this.pending.length; )
      if (this.pending[i].seq <= state.acked) this.pending.splice(i, 1);
      else me.apply(this.pending[i++]);
  }

  input(now, server, me, key) {
    const dt = (now - (this.last ?? now)) / 1000;
    this.last = now;
    if (key === 0) return;
    const input = { press_time: key * dt, seq: this.seq++, entity: this.id };
    server.network.send(this.lag, now, input);
    if (this.prediction) me.apply(input);
    this.pending.push(input);
  }

  interpolate(now, updateHz) {
    const time = now - 1000 / updateHz;
    for (const entity of this.entities.values()) {
      if (entity.id === this.id) continue;
      const buffer = entity.buffer;
      while (buffer.length >= 2 && buffer[1].time <= time) buffer.shift();
      if (buffer.length < 2 || buffer[0].time > time || time > buffer[1].time) continue;
      const [a, b] = buffer;
      entity.x = a.x + ((b.x - a.x) * (time - a.time)) / (b.time - a.time);
    }
  }
}

class Server {
  network = new LagNetwork();
  clients = [];
  entities = [];
  acked = [];

  constructor(updateHz) {
    this.updateHz = updateHz;
  }
  connect(client) {
    this.entities.push(new Entity(client.id, [4, 6][client.id]));
    this.clients.push(client);
  }

  update(now) {
    for (let input; (input = this.network.receive(now)); ) {
      if (Math.abs(input.press_time) > 1 / 40) continue;
      this.entities[input.entity].apply(input);
      this.acked[input.entity] = input.seq;
    }
    const state = this.entities.map((entity) => ({ entity: entity.id, x: entity.x, acked: this.acked[entity.id] }));
    for (const client of this.clients) client.network.send(client.lag, now, state);
  }
}

/** Both players hold a key all the time and turn round every second, so that there always is an input to predict. */
const key = (now, player) => ((Math.floor(now / 1000) + player) % 2 === 0 ? 1 : -1);

/** @returns {{x: number[], shown: number[][], frames: number, updates: number}} */
export function simulate({ seconds, updateHz, lags, clientHz = 50, ...techniques }) {
  const server = new Server(updateHz);
  const clients = lags.map((lag, id) => new Client(id, lag, techniques));
  clients.forEach((client) => server.connect(client));
  const end = seconds * 1000;
  let frames = 0;
  let updates = 0;
  for (let now = 0; now < end; ) {
    const frame = (frames * 1000) / clientHz;
    const update = (updates * 1000) / updateHz;
    now = Math.min(frame, update);
    if (frame === now) {
      for (const client of clients) client.update(now, server, key(now, client.id));
      frames++;
    }
    if (update === now) {
      server.update(now);
      updates++;
    }
  }
  return {
    x: server.entities.map((entity) => entity.x),
    shown: clients.map((client) => server.entities.map((entity) => client.entities.get(entity.id)?.x)),
    frames,
    updates,
  };
}

// node demo_model.mjs '{"seconds":3600,"updateHz":30,"lags":[150,250],...}' -> one line of JSON with the CPU time it took
if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const options = JSON.parse(process.argv[2]);
  simulate({ ...options, seconds: 3600 }); // lets the compiler finish first
  const before = process.cpuUsage();
  const begin = performance.now();
  const result = simulate(options);
  const cpu = process.cpuUsage(before);
  console.log(JSON.stringify({ cpu_s: (cpu.user + cpu.system) / 1e6, wall_s: (performance.now() - begin) / 1e3, ...result }));
}
