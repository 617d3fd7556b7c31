// The stage: metres on the page. Canvas for the picture below, SVG for drawings over it. The SVG's
// units are the picture's pixels; `k` of them are one pixel of the screen.

const SVG = "http://www.w3.org/2000/svg";
const MOST_ZOOM = 12;

export class Stage {
  constructor() {
    this.element = document.getElementById("stage");
    this.canvas = document.getElementById("picture");
    this.svg = document.getElementById("overlay");
    this.window = null;
    this.k = 1;
    /** The part of the picture that is shown, in its pixels: {x, y, w, h}. */
    this.view = null;
    /** Takes presses and keys in place of goals and robots, if anything does. */
    this.tool = null;
    this.onResize = [];
    new ResizeObserver(() => this.#measure()).observe(this.element);
  }

  fit(hello) {
    const [width, height] = hello.picture_px;
    this.window = hello.window_m;
    this.scale = width / (hello.window_m[2] - hello.window_m[0]);
    [this.width, this.height] = [width, height];
    const isNew = !this.view || this.whole !== `${width} ${height}`;
    this.whole = `${width} ${height}`;
    this.element.style.setProperty("--aspect", `${width} / ${height}`);
    this.element.style.setProperty("--ratio", width / height);
    this.show(isNew ? null : this.view);
  }

  allowed(w) {
    return Math.min(this.width, Math.max(this.width / MOST_ZOOM, w));
  }

  /** Show a part of the picture, {x, y, w} in its pixels; null for the whole. */
  show(part) {
    if (!this.window) return;
    const w = part ? this.allowed(part.w) : this.width;
    const h = (w * this.height) / this.width;
    const x = Math.min(this.width - w, Math.max(0, part?.x ?? 0));
    const y = Math.min(this.height - h, Math.max(0, part?.y ?? 0));
    this.view = { x, y, w, h };
    this.svg.setAttribute("viewBox", `${x} ${y} ${w} ${h}`);
    const moved = `scale(${this.width / w}) translate(${(-100 * x) / this.width}%, ${(-100 * y) / this.height}%)`;
    for (const canvas of this.element.querySelectorAll("canvas")) canvas.style.transform = moved;
    this.#measure();
  }

  /** Move the view so that a place, metres, is well inside of it. */
  reveal(x_m, y_m) {
    if (!this.view) return;
    const { x, y, w, h } = this.view;
    const [px, py] = [this.x(x_m), this.y(y_m)];
    const [mx, my] = [w / 8, h / 8];
    if (px >= x + mx && px <= x + w - mx && py >= y + my && py <= y + h - my) return;
    this.show({ x: Math.min(px - mx, Math.max(px + mx - w, x)), y: Math.min(py - my, Math.max(py + my - h, y)), w });
  }

  /** Width of the whole picture on the screen, in the screen's own pixels. */
  get width_px() {
    const times = this.view ? this.width / this.view.w : 1;
    return Math.max(1, Math.ceil(this.element.clientWidth * times * devicePixelRatio));
  }

  #measure() {
    if (!this.window) return;
    const shown = this.element.clientWidth || this.width;
    this.k = this.view.w / shown;
    this.svg.style.setProperty("--k", this.k);
    for (const listener of this.onResize) listener();
  }

  x(metres) {
    return (metres - this.window[0]) * this.scale;
  }

  y(metres) {
    return (this.window[3] - metres) * this.scale;
  }

  pixel(event) {
    const box = this.svg.getBoundingClientRect();
    return [
      this.view.x + ((event.clientX - box.left) / box.width) * this.view.w,
      this.view.y + ((event.clientY - box.top) / box.height) * this.view.h,
    ];
  }

  /** The place under a pointer event, metres. */
  place(event) {
    const [x, y] = this.pixel(event);
    return [this.window[0] + x / this.scale, this.window[3] - y / this.scale];
  }

  /** A place, metres, on the screen. */
  onScreen(x_m, y_m) {
    const box = this.svg.getBoundingClientRect();
    return [
      box.left + ((this.x(x_m) - this.view.x) / this.view.w) * box.width,
      box.top + ((this.y(y_m) - this.view.y) / this.view.h) * box.height,
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

export function element(name, attributes = {}, text = undefined) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}
