"""Node.js, started once for many questions, since its start takes longer than most of them."""

from __future__ import annotations

import json
import subprocess
from contextlib import contextmanager
from select import select

WITHIN_S = 60.0
LOOP = r"""
import { createInterface } from 'node:readline';
for await (const line of createInterface({ input: process.stdin })) {
  let reply;
  try {
    reply = { value: await answer(JSON.parse(line)) };
  } catch (error) {
    reply = { error: `${error.stack}` };
  }
  process.stdout.write(`${JSON.stringify(reply)}\n`);
}
"""


@contextmanager
def running_node(folder, program):
    """Yield a function that asks Node; the program, a module in that folder, defines `answer`."""
    words = ["node", "--input-type=module", "-e", program + LOOP]
    with subprocess.Popen(
        words, cwd=folder, stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8"
    ) as process:

        def ask(question):
            process.stdin.write(f"{json.dumps(question)}\n")
            process.stdin.flush()
            assert select([process.stdout], [], [], WITHIN_S)[0], "Node does not answer"
            answer = json.loads(process.stdout.readline())
            assert "error" not in answer, answer["error"]
            return answer.get("value")

        try:
            yield ask
        finally:
            process.kill()
