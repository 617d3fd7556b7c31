// The page of a live calibration: asks for the state, and draws it over the picture it belongs to.

const ASK_EVERY_MS = 120;
const ASK_AGAIN_MS = 2000;
const LOST_AFTER = 3;
const SVG = "http://www.w3.org/2000/svg";
const byId = (id) => document.getElementById(id);
let lastFrame = null;
let failures = 0;
let enough = false;

function element(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

function say(id, text) {
  const place = byId(id);
  if (place.textContent !== text) place.textContent = text;
}

function phase(text, state) {
  say("phase", text);
  byId("phase").dataset.state = state;
}

const upper = (text) => text.slice(0, 1).toUpperCase() + text.slice(1);
const path = (points) => points.map((p) => p.join(",")).join(" ");

function drawCells(overlay, state) {
  const [width, height] = state.size;
  const rows = state.cells.length, columns = state.cells[0].length;
  const w = width / columns, h = height / rows;
  state.cells.forEach((line, row) => line.forEach((cell, column) => {
    const kind = cell.done ? "done" : cell.seen ? "seen" : "unseen";
    const x = column * w, y = row * h;
    overlay.append(element("rect", { class: `cell ${kind}`, x, y, width: w, height: h }));
    const word = cell.done ? "✓" : cell.px === null ? "" : cell.px >= 10 ? ">10" : cell.px.toFixed(2);
    overlay.append(element("text", { class: "px", x: x + w / 2, y: y + h / 2, "font-size": w / 7 }, word));
  }));
}

function drawBoard(overlay, state) {
  if (state.wanted && !state.done) {
    for (const kind of ["halo", "line"]) {
      overlay.append(element("polygon", { class: `asked-${kind}`, points: path(state.wanted) }));
    }
  }
  if (!state.outline) return;
  for (const kind of ["halo", "line"]) {
    overlay.append(element("polygon", { class: `board-${kind}`, points: path(state.outline) }));
  }
  for (const [cx, cy] of state.corners) {
    overlay.append(element("circle", { class: "corner", cx, cy, r: state.size[0] / 260 }));
  }
}

function drawn(state) {
  const overlay = byId("overlay");
  overlay.setAttribute("viewBox", `-0.5 -0.5 ${state.size[0]} ${state.size[1]}`);
  document.querySelector(".frame").style.aspectRatio = `${state.size[0]} / ${state.size[1]}`;
  overlay.replaceChildren();
  drawCells(overlay, state);
  drawBoard(overlay, state);
}

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
      drawn(answer.state);
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
