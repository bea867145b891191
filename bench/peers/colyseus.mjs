// Peer: Colyseus over its ws transport. node colyseus.mjs SESSIONS VIEWERS BYTES (Node >= 22)
// One room per session. Frames go out as raw bytes (broadcastBytes), so no schema is encoded: the cheapest that Colyseus can do.
import { Room, Server, matchMaker } from '@colyseus/core';
import { WebSocketTransport } from '@colyseus/ws-transport';
import { announce, makeFrame, options, pace, stamp } from './frame.mjs';

const { sessions, viewers, bytes, hz } = options();
const FRAME = 0; // types of messages: one byte each on the wire
const ACK = 1;

class Session extends Room {
  patchRate = null; // no state, so no patches
  maxClients = 100000;
  seatReservationTimeout = 120;
  seq = 0;

  onCreate() {
    this.onMessageBytes(ACK, (client, payload) => {
      client.acked = payload;
    });
  }

  send() {
    if (this.clients.length === 0) return;
    const frame = makeFrame(bytes);
    stamp(frame, ++this.seq);
    this.broadcastBytes(FRAME, frame);
  }
}

const transport = new WebSocketTransport({ pingInterval: 3000 });
const server = new Server({ transport, greet: false });
server.define('session', Session);
await server.listen(0, '127.0.0.1');

const rooms = [];
const paths = [];
for (let s = 0; s < sessions; s++) {
  const { roomId } = await matchMaker.createRoom('session', {});
  rooms.push(matchMaker.getLocalRoomById(roomId));
  for (let v = 0; v < viewers; v++) {
    const seat = await matchMaker.joinById(roomId, {});
    paths.push(`/${seat.processId ?? seat.room?.processId}/${roomId}?sessionId=${seat.sessionId}`);
  }
}
announce(transport.server.address().port, paths);
pace(() => rooms.forEach((room) => room.send()), hz);
