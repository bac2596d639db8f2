// SPDX-License-Identifier: Apache-2.0
// Statements that hold or do not, counted.

let passed = 0;
let failed = 0;

export function check(statement, holds, found) {
  if (holds) ++passed; else ++failed;
  const instead = holds || found === undefined ? '' : `; found ${JSON.stringify(found)}`;
  console.log(`${holds ? 'ok  ' : 'FAIL'}  ${statement}${instead}`);
}

// Says how many, and ends the program: with 0 where all hold.
export function end() {
  console.log(`${passed} passed, ${failed} failed`);
  process.exit(failed ? 1 : 0);
}
