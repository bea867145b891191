// Peer: a Node `ws` server. node ws.mjs SESSIONS VIEWERS BYTES [HZ]
import { WebSocketServer } from 'ws';
import { announce, makeFrame, options, pace, stamp } from './frame.mjs';

const { sessions, viewers, bytes, hz } = options();
const rooms = Array.from({ length: sessions }, () => ({ seq: 0, clients: new Set() }));

const server = new WebSocketServer({ port: 0, host: '127.0.0.1', perMessageDeflate: false }, () =>
  announce(
    server.address().port,
    rooms.flatMap((_, s) => Array(viewers).fill(`/${s}`)),
  ),
);

server.on('connection', (socket, request) => {
  const room = rooms[Number(request.url.slice(1))];
  room.clients.add(socket);
  socket.acked = 0;
  // {"ack":N}, read as cheaply as the daemon reads it.
  socket.on('message', (data) => {
    socket.acked = Number(data.toString('latin1', 7, data.length - 1));
  });
  socket.on('close', () => room.clients.delete(socket));
});

pace(() => {
  for (const room of rooms) {
    if (room.clients.size === 0) continue;
    const frame = makeFrame(bytes); // a new one: the socket may still hold the last
    stamp(frame, ++room.seq);
    for (const client of room.clients) client.send(frame);
  }
}, hz);
