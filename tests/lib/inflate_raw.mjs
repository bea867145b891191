// Debian 12 has Node 18, whose DecompressionStream lacks `deflate-raw`; browsers have had it since 2023, Node since 20.12.
import { Duplex } from 'node:stream';
import { createInflateRaw } from 'node:zlib';

const Built = globalThis.DecompressionStream;
try {
  new Built('deflate-raw');
} catch {
  globalThis.DecompressionStream = /** @type {any} */ (
    class {
      /** @param {CompressionFormat} format */
      constructor(format) {
        const pair = format === 'deflate-raw' ? /** @type {any} */ (Duplex).toWeb(createInflateRaw()) : new Built(format);
        this.readable = pair.readable;
        this.writable = pair.writable;
      }
    }
  );
}
