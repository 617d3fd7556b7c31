// The page of a live calibration: asks for the state, and draws it over the picture it belongs to.

import { drawBoardView } from "./board.js";

const ASK_EVERY_MS = 120;
const ASK_AGAIN_MS = 2000;
const LOST_AFTER = 3;
const byId = (id) => document.getElementById(id);
let lastFrame = null;
let failures = 0;
let enough = false;

function say(id, text) {
  const place = byId(id);
  if (place.textContent !== text) place.textContent = text;
}

function phase(text, state) {
  say("phase", text);
  byId("phase").dataset.state = state;
}

const upper = (text) => text.slice(0, 1).toUpperCase() + text.slice(1);
function tell(state, remarks) {
  say("sentence", upper(state.sentence));
  say("board", upper(state.board.replace(/^board: /, "")));
  byId("still").value = state.still;
  say("spread", state.spread);
  say("limit", `${state.limit_px} px`);
  byId("known").value = state.worst_px === null ? 0 : Math.min(1, state.limit_px / state.worst_px);
  say("focal", upper(state.focal));
  say("parts", upper(state.parts));
  say("count", String(state.count));
  const list = byId("remarks");
  if (list.childElementCount !== remarks.length || list.firstChild?.textContent !== remarks.at(-1)) {
    list.replaceChildren(...remarks.toReversed().map((text) => {
      const item = document.createElement("li");
      item.textContent = text;
      return item;
    }));
  }
  enough = state.done;
  if (state.done) phase("enough views", "good");
  else if (!state.outline) phase("no board seen", "warn");
  else if (state.still > 0) phase("hold still", "good");
  else phase("board seen", "");
}

async function pictureOf(frame) {
  const picture = byId("picture");
  picture.src = `picture.jpg?frame=${frame}`;
  await picture.decode().catch(() => undefined);
}

async function ask() {
  try {
    const answer = await (await fetch("state")).json();
    failures = 0;
    if (answer.state && answer.state.frame !== lastFrame) {
      lastFrame = answer.state.frame;
      await pictureOf(lastFrame);
      drawBoardView(document.querySelector(".frame"), byId("overlay"), answer.state);
      tell(answer.state, answer.remarks);
    }
    if (answer.ended) {
      phase("ended", "good");
      say("sentence", upper(answer.ended));
      return;
    }
  } catch {
    failures += 1;
    if (failures >= LOST_AFTER) {
      phase(enough ? "enough views; the program has ended" : "the program has ended, or is not reached", enough ? "good" : "bad");
    }
  }
  setTimeout(ask, failures >= LOST_AFTER ? ASK_AGAIN_MS : ASK_EVERY_MS);
}

ask();
