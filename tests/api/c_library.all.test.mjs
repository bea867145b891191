// The C library under valgrind.
import { test } from 'node:test';
import { install } from '../lib/c_library.mjs';

test('no byte is leaked or read wrongly', async (t) => {
  const library = await install();
  t.after(library.remove);
  await library.everything(['valgrind', '--quiet', '--leak-check=full', '--errors-for-leak-kinds=all', '--error-exitcode=9']);
});
