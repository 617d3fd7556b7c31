// A live calibration drawn over its picture: the parts, the board, and where it is wanted.

const SVG = "http://www.w3.org/2000/svg";

function element(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

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

/** Draw a state into an SVG element over the picture, in a frame of its shape (board.css). */
export function drawBoardView(frame, overlay, state) {
  overlay.setAttribute("viewBox", `-0.5 -0.5 ${state.size[0]} ${state.size[1]}`);
  frame.style.setProperty("--ratio", state.size[0] / state.size[1]);
  overlay.replaceChildren();
  drawCells(overlay, state);
  drawBoard(overlay, state);
}
