// Proves that check.mjs can fail: it must find exactly the breaches of the small tree in fixture/.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { execPath } from 'node:process';
import { fileURLToPath } from 'node:url';
import { check } from './check.mjs';

const root = fileURLToPath(new URL('fixture', import.meta.url));

assert.deepEqual(check(root).findings, [
  'src/attic/old.c:1: attic is not one of the rooms',
  'src/base/bad.c:12: base calls time()',
  'src/base/bad.c:13: base calls powf()',
  'src/base/bad.c:2: base includes "play/fine.h", and may not use play',
  'src/base/bad.c:3: includes "unknown/x.h", which is in no room',
  'src/base/bad.c:5: the public function unprefixed does not start with ll_',
  'src/base/bad.c:7: base calls rand()',
  'src/base/bad.c:7: base calls sin()',
  'src/base/knows.h:2: base knows struct ll_part of game/b/part.h, and may not use game/b',
  'src/game/a/loop.inc:1: includes "../../play/fine.h", which is in no room',
  'src/game/a/loop.inc:4: game/a calls getenv()',
  'src/game/a/one.c:1: in a circle: one.c, three.c, two.c',
  'src/game/a/one.h:1: in a circle: one.h, two.h',
  'src/game/a/sibling.c:1: the exception for game/b/maker.c is not needed',
  'src/game/a/sibling.c:2: game/a includes "game/b/part.h", and may not use game/b',
  'src/game/a/sibling.c:3: game/a uses ll_parts of game/b/part.c, and may not use game/b',
  'src/game/a/sibling.c:6: game/a calls calloc()',
  'tests/structure/rooms.txt:1: except game/a/sibling.c -> game/b/maker.c: no reason is given',
  'tests/structure/rooms.txt:1: game/b: there is no room unknown',
]);

const script = fileURLToPath(new URL('check.mjs', import.meta.url));
assert.equal(spawnSync(execPath, [script, root]).status, 1, 'the command must fail on the fixture');
console.log('the check finds what it must');
