// The stage: where metres lie on the page. Canvas for the picture below, SVG for what is drawn
// over it. The SVG's units are the picture's pixels; `k` of them are one pixel of the screen.

const SVG = "http://www.w3.org/2000/svg";

export class Stage {
  constructor() {
    this.element = document.getElementById("stage");
    this.canvas = document.getElementById("picture");
    this.svg = document.getElementById("overlay");
    this.window = null;
    this.k = 1;
    this.onResize = [];
    new ResizeObserver(() => this.#measure()).observe(this.element);
  }

  /** The greeting says which part of the floor is shown, and in how many pixels. */
  fit(hello) {
    const [width, height] = hello.picture_px;
    this.window = hello.window_m;
    this.scale = width / (hello.window_m[2] - hello.window_m[0]);
    [this.width, this.height] = [width, height];
    if (this.canvas.width !== width || this.canvas.height !== height) {
      [this.canvas.width, this.canvas.height] = [width, height];
    }
    this.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.element.style.setProperty("--aspect", `${width} / ${height}`);
    this.element.style.setProperty("--ratio", width / height);
    this.#measure();
  }

  #measure() {
    if (!this.window) return;
    const shown = this.element.clientWidth || this.width;
    this.k = this.width / shown;
    this.svg.style.setProperty("--k", this.k);
    for (const listener of this.onResize) listener();
  }

  x(metres) {
    return (metres - this.window[0]) * this.scale;
  }

  y(metres) {
    return (this.window[3] - metres) * this.scale;
  }

  /** The place under a pointer event, metres. */
  place(event) {
    const box = this.svg.getBoundingClientRect();
    return [
      this.window[0] + ((event.clientX - box.left) / box.width) * (this.window[2] - this.window[0]),
      this.window[3] - ((event.clientY - box.top) / box.height) * (this.window[3] - this.window[1]),
    ];
  }

  /** Path data of points (flat x, y, ... metres), from the n-th to before the m-th. */
  line(points, from = 0, to = points.length / 2) {
    let data = "";
    let move = "M";
    for (let k = from; k < to; k++) {
      if (Number.isNaN(points[2 * k])) {
        move = "M"; // the line breaks here
        continue;
      }
      const x = this.x(points[2 * k]).toFixed(1);
      const y = this.y(points[2 * k + 1]).toFixed(1);
      data += `${move}${x} ${y}`;
      move = "L";
    }
    return data;
  }

  group(name) {
    const found = this.svg.querySelector(`[data-layer="${name}"]`);
    if (found) return found;
    const made = element("g", { "data-layer": name });
    this.svg.append(made);
    return made;
  }
}

/** An SVG element with attributes. */
export function element(name, attributes = {}, text = undefined) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}
