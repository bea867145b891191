// Proves that check.mjs can fail: it must find exactly the breaches of the small tree beside it.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { execPath } from "node:process";
import { fileURLToPath } from "node:url";
import { check } from "./check.mjs";

const root = fileURLToPath(new URL("fixture", import.meta.url));

assert.deepEqual(check(root).findings, [
  "src/attic/old.c:1: attic is not one of the rooms",
  'src/base/bad.c:2: base includes "game/fine.h", a room above it',
  'src/base/bad.c:3: includes "nowhere/x.h", which is in no room',
  "src/base/bad.c:7: base calls sin()",
  "src/base/bad.c:7: base calls rand()",
  "src/base/bad.c:12: base calls time()",
  "src/base/bad.c:13: base calls powf()",
  "src/base/bad.c:5: the public function unprefixed does not start with ll_",
]);

const script = fileURLToPath(new URL("check.mjs", import.meta.url));
assert.equal(spawnSync(execPath, [script, root]).status, 1, "the command must fail on the fixture");
console.log("the check finds what it must");
