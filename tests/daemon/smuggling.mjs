// Requests that two parsers could read differently. tests/daemon/smuggling.test.mjs sends them to the daemon.
//
// Each is [name, bytes, status, what else]. The daemon gives one answer, with this status (0: it closes without one), and closes the
// connection; it goes on with the next request only at GOES_ON. A refusal is a problem document, except where libmicrohttpd refuses by
// itself (BY_LIBRARY, or KEPT_BY_LIBRARY: behind other requests of the connection; TWICE: there it even sends its answer's head twice).
// HIDDEN is in what one of two parsers may take for a body.

export const BODY = '{"scenario":"race","paused":true}';
export const HIDDEN = 'GET /api/v1/creation HTTP/1.1\r\nHost: localhost\r\n\r\n';
export const FOLLOWER = 'GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n';

const SIZE = BODY.length;
const get = (headers = '', target = '/readyz', version = 'HTTP/1.1', host = 'Host: localhost\r\n') =>
  `GET ${target} ${version}\r\n${host}${headers}\r\n`;
const post = (/** @type {string} */ headers, body = BODY) =>
  `POST /api/v1/sessions HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n${headers}\r\n${body}`;
const chunks = (/** @type {string} */ body, coding = 'Transfer-Encoding: chunked\r\n') => post(coding, body);
const HEX = SIZE.toString(16);
const WHOLE = `${HEX}\r\n${BODY}\r\n0\r\n\r\n`;
export const GOES_ON = 'goes on',
  BY_LIBRARY = 'by the library',
  KEPT_BY_LIBRARY = 'kept, by the library',
  TWICE = 'kept, twice by the library';

/** @type {[string, string, number, string?][]} */
export const REQUESTS = [
  // what is right
  ['GET', get(), 200, GOES_ON],
  ['POST with a Content-Length', post(`Content-Length: ${SIZE}\r\n`), 201, GOES_ON],
  ['POST in chunks', chunks(WHOLE), 201, GOES_ON],
  ['a Content-Length with zeros before it', post(`Content-Length: 000${SIZE}\r\n`), 201, GOES_ON],
  ['whitespace before a Content-Length', post(`Content-Length: \t ${SIZE}\r\n`), 201, GOES_ON],
  ['Transfer-Encoding in capitals', chunks(WHOLE, 'TRANSFER-ENCODING: CHUNKED\r\n'), 201, GOES_ON],
  ['whitespace before a Transfer-Encoding', chunks(WHOLE, 'Transfer-Encoding: \t chunked\r\n'), 201, GOES_ON],
  ['a chunk extension', chunks(`${HEX};name=value\r\n${BODY}\r\n0;last\r\n\r\n`), 201, GOES_ON],
  ['a chunk size with zeros before it', chunks(`000${HEX}\r\n${BODY}\r\n000\r\n\r\n`), 201, GOES_ON],
  ['a trailer', chunks(`${HEX}\r\n${BODY}\r\n0\r\nX-Check: 1\r\n\r\n`), 201, GOES_ON],
  ['empty lines before a request', `\r\n\r\n${get()}`, 200, GOES_ON],
  ['a header without a value', get('X-Empty:\r\n'), 200, GOES_ON],
  ['absolute form', get('', 'http://localhost/readyz'), 200, GOES_ON],
  [
    'absolute form, whose host is not that of Host',
    get('', 'HTTP://127.0.0.1:1/readyz', 'HTTP/1.1', 'Host: lab.example\r\n'),
    200,
    GOES_ON,
  ],
  ['a point behind the host', get('', '/readyz', 'HTTP/1.1', 'Host: localhost.\r\n'), 200, GOES_ON],
  ['Expect', post(`Content-Length: ${SIZE}\r\nExpect: 100-continue\r\n`), 201, GOES_ON],

  // Content-Length and Transfer-Encoding
  ['Content-Length, then Transfer-Encoding', post('Content-Length: 6\r\nTransfer-Encoding: chunked\r\n', `0\r\n\r\n${HIDDEN}`), 400],
  ['Transfer-Encoding, then Content-Length', post(`Transfer-Encoding: chunked\r\nContent-Length: ${SIZE}\r\n`, `0\r\n\r\n${HIDDEN}`), 400],
  ['two Content-Lengths', post(`Content-Length: ${SIZE}\r\nContent-Length: 0\r\n`), 400],
  ['two equal Content-Lengths', post(`Content-Length: ${SIZE}\r\nContent-Length: ${SIZE}\r\n`), 400],
  ['whitespace behind a Content-Length', post(`Content-Length: ${SIZE} \r\n`), 400, TWICE],
  ['a list of Content-Lengths', post(`Content-Length: ${SIZE}, ${SIZE}\r\n`), 400, TWICE],
  ['a Content-Length with +', post(`Content-Length: +${SIZE}\r\n`), 400, TWICE],
  ['a Content-Length with -', post('Content-Length: -1\r\n'), 400, TWICE],
  ['a Content-Length in hexadecimal', post(`Content-Length: 0x${HEX}\r\n`), 400, TWICE],
  ['a Content-Length of 2^64', post('Content-Length: 18446744073709551616\r\n'), 413, TWICE],
  ['a Content-Length of 2^64 - 1', post('Content-Length: 18446744073709551615\r\n'), 413],
  ['a Content-Length of 2^63', post('Content-Length: 9223372036854775808\r\n'), 413],
  ['a Content-Length of 40 digits', post(`Content-Length: ${'9'.repeat(40)}\r\n`), 413, TWICE],
  ['a Content-Length with a point', post(`Content-Length: ${SIZE}.0\r\n`), 400, TWICE],
  ['a Content-Length with an exponent', post('Content-Length: 1e1\r\n'), 400, TWICE],
  ['a Content-Length with a space in it', post('Content-Length: 3 3\r\n'), 400, TWICE],
  ['a Content-Length in quotes', post(`Content-Length: "${SIZE}"\r\n`), 400, TWICE],
  ['a Content-Length without a value', post('Content-Length:\r\n', ''), 400, TWICE],
  ['a Content-Length of letters', post('Content-Length: many\r\n'), 400, TWICE],
  ['a space before the colon of Content-Length', post(`Content-Length : ${SIZE}\r\n`), 400],
  ['a tab before the colon of Content-Length', post(`Content-Length\t: ${SIZE}\r\n`), 400],
  ['a Content-Length behind a vertical tab', post(`Content-Length: \v${SIZE}\r\n`), 400, TWICE],
  ['Content-Length and Content_Length', post(`Content-Length: ${SIZE}\r\nContent_Length: 0\r\n`), 201, GOES_ON],
  ['a body where none is read', get(`Content-Length: ${HIDDEN.length}\r\n`) + HIDDEN, 413, GOES_ON],
  ['two equal Transfer-Encodings', chunks(WHOLE, 'Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n'), 400],
  ['Transfer-Encoding chunked, then identity', chunks(WHOLE, 'Transfer-Encoding: chunked\r\nTransfer-Encoding: identity\r\n'), 400],
  ['a list chunked, chunked', chunks(WHOLE, 'Transfer-Encoding: chunked, chunked\r\n'), 501],
  ['a list gzip, chunked', chunks(WHOLE, 'Transfer-Encoding: gzip, chunked\r\n'), 501],
  ['a list identity, chunked', chunks(WHOLE, 'Transfer-Encoding: identity, chunked\r\n'), 501],
  ['a list that begins with a comma', chunks(WHOLE, 'Transfer-Encoding: ,chunked\r\n'), 501],
  ['whitespace behind a Transfer-Encoding', chunks(WHOLE, 'Transfer-Encoding: chunked \r\n'), 501],
  ['identity', chunks(WHOLE, 'Transfer-Encoding: identity\r\n'), 501],
  ['xchunked', chunks(WHOLE, 'Transfer-Encoding: xchunked\r\n'), 501],
  ['chunked in quotes', chunks(WHOLE, 'Transfer-Encoding: "chunked"\r\n'), 501],
  ['chunked with a parameter', chunks(WHOLE, 'Transfer-Encoding: chunked;q=1\r\n'), 501],
  ['chunked behind a vertical tab', chunks(WHOLE, 'Transfer-Encoding: \vchunked\r\n'), 400],
  ['chunked before a form feed', chunks(WHOLE, 'Transfer-Encoding: chunked\f\r\n'), 400],
  ['a Transfer-Encoding without a value', chunks(WHOLE, 'Transfer-Encoding:\r\n'), 501],
  ['a folded Transfer-Encoding', chunks(WHOLE, 'Transfer-Encoding:\r\n chunked\r\n'), 400],
  ['a space before the colon of Transfer-Encoding', chunks(WHOLE, 'Transfer-Encoding : chunked\r\n'), 400],
  ['a space before Transfer-Encoding', chunks(WHOLE, ' Transfer-Encoding: chunked\r\n'), 400],
  ['Transfer-Encoding in HTTP/1.0', chunks(WHOLE).replace('HTTP/1.1', 'HTTP/1.0'), 400],

  // chunks
  ['a chunk size with +', chunks(`+${HEX}\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a chunk size with -', chunks(`-${HEX}\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a chunk size with 0x', chunks(`0x${HEX}\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a chunk size of letters', chunks(`size\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a chunk size without digits', chunks(`\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a chunk size with a space before it', chunks(` ${HEX}\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a chunk size with an underscore', chunks(`2_1\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a chunk size of 2^64 + 33', chunks(`1000000000000000${HEX}\r\n${BODY}\r\n0\r\n\r\n`), 413, BY_LIBRARY],
  ['a chunk size of 2^64 - 1', chunks(`ffffffffffffffff\r\n${BODY}\r\n0\r\n\r\n`), 0],
  ['a chunk that is longer than its size', chunks(`5\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a chunk size behind a semicolon', chunks(`;${HEX}\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a NUL in a chunk size', chunks(`${HEX}\0\r\n${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a bare CR behind a chunk size', chunks(`${HEX}\rX${BODY}\r\n0\r\n\r\n`), 400, BY_LIBRARY],
  ['a chunk extension of 100 kB', chunks(`${HEX};x=${'y'.repeat(100000)}\r\n${BODY}\r\n0\r\n\r\n`), 500, BY_LIBRARY],
  ['a trailer of 100 kB', chunks(`${HEX}\r\n${BODY}\r\n0\r\nX-Long: ${'y'.repeat(100000)}\r\n\r\n`), 431, BY_LIBRARY],
  ['a trailer that is no header', chunks(`${HEX}\r\n${BODY}\r\n0\r\nnothing\r\n\r\n`), 400, BY_LIBRARY],
  ['a request where a trailer should be', chunks(`${HEX}\r\n${BODY}\r\n0\r\n${HIDDEN}`), 400, BY_LIBRARY],

  // line ends
  ['LF as the end of lines', get().replaceAll('\r\n', '\n'), 200, GOES_ON],
  ['LF behind a chunk size', chunks(`${HEX}\n${BODY}\r\n0\r\n\r\n`), 201, GOES_ON],
  ['a bare CR in a header', get('X-One: a\rX-Two: b\r\n'), 400],
  ['a bare CR as the end of a line', 'GET /readyz HTTP/1.1\rHost: localhost\r\r', 400],
  ['a bare CR before a Content-Length', post(`X-One: a\rContent-Length: 0\r\nContent-Length: ${SIZE}\r\n`), 400],
  ['a NUL in a header', get('X-One: a\0b\r\n'), 400],
  ['a NUL in a name', get('X-O\0ne: a\r\n'), 400, KEPT_BY_LIBRARY],
  ['a NUL in the target', get('', '/ready\0z'), 400],
  ['a folded header', get('X-One: a\r\n b\r\n'), 400],
  ['a line without a colon', get('nothing\r\n'), 400, KEPT_BY_LIBRARY],
  ['a header without a name', get(': a\r\n'), 400],
  ['a space in a name', get('X One: a\r\n'), 400],

  // what may come once
  ['two Origins', post(`Origin: http://localhost\r\nOrigin: http://lab.example\r\nContent-Length: ${SIZE}\r\n`), 400],
  ['two Authorizations', get('Authorization: Bearer a\r\nAuthorization: Bearer b\r\n'), 400],
  ['two Content-Types', post(`Content-Type: text/plain\r\nContent-Length: ${SIZE}\r\n`), 400],

  // Host
  ['two Hosts', get('Host: lab.example\r\n'), 400],
  ['two equal Hosts', get('Host: localhost\r\n'), 400],
  ['no Host', get('', '/readyz', 'HTTP/1.1', ''), 400, GOES_ON],
  ['a Host without a value', get('', '/readyz', 'HTTP/1.1', 'Host:\r\n'), 421, GOES_ON],
  ['another Host', get('', '/readyz', 'HTTP/1.1', 'Host: lab.example\r\n'), 421, GOES_ON],
  ['a list of Hosts', get('', '/readyz', 'HTTP/1.1', 'Host: localhost, lab.example\r\n'), 421, GOES_ON],
  ['a user in Host', get('', '/readyz', 'HTTP/1.1', 'Host: localhost@lab.example\r\n'), 421, GOES_ON],
  ['absolute form with another host', get('', 'http://lab.example/readyz'), 421, GOES_ON],
  ['absolute form with a user', get('', 'http://localhost@lab.example/readyz'), 421, GOES_ON],
  ['absolute form with a % in the host', get('', 'http://lab.example%2f@localhost/readyz'), 400],

  // the first line
  ['HTTP/0.9', 'GET /readyz\r\n\r\n', 400, KEPT_BY_LIBRARY],
  ['HTTP/1.2', get('', '/readyz', 'HTTP/1.2'), 200, GOES_ON],
  ['HTTP/2.0', get('', '/readyz', 'HTTP/2.0'), 505, KEPT_BY_LIBRARY],
  ['http/1.1', get('', '/readyz', 'http/1.1'), 400, KEPT_BY_LIBRARY],
  ['the preface of HTTP/2', 'PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n', 505, KEPT_BY_LIBRARY],
  ['two spaces in the first line', get('', '/readyz '), 400],
  ['a tab in the first line', get('', '/readyz\tx'), 400],
  ['a space in the target', get('', '/ready z'), 400],
  ['a method in small letters', get().replace('GET', 'get'), 400],
  ['a method of symbols', get().replace('GET', 'G@T'), 400],
  ['CONNECT', get('', 'localhost:80').replace('GET', 'CONNECT'), 405, GOES_ON],
  ['TRACE', get().replace('GET', 'TRACE'), 405, GOES_ON],

  // ways out of the folder of the page
  ['../', get('', '/../../etc/passwd'), 404, GOES_ON],
  ['%2e%2e/', get('', '/%2e%2e/%2e%2e/etc/passwd'), 404, GOES_ON],
  ['..%2f', get('', '/..%2f..%2fetc%2fpasswd'), 404, GOES_ON],
  ['%252e%252e', get('', '/%252e%252e/etc/passwd'), 404, GOES_ON],
  ['..\\', get('', '/..\\..\\etc\\passwd'), 404, GOES_ON],
  ['//', get('', '//etc/passwd'), 404, GOES_ON],
  ['%00', get('', '/index.html%00.js'), 400],
  ['%00 in the query', get('', '/api/v1/schema?kind=fluid%00x'), 400],
  ['65 arguments', get('', `/readyz?${'a=1&'.repeat(64)}b=1`), 400],
  ['700 arguments', get('', `/readyz?${'a=1&'.repeat(699)}b=1`), 400],
  ['a foreign scheme', get('', 'file:///etc/passwd'), 404, GOES_ON],
];
