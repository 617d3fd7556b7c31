// The shown part of the picture: zoomed by wheel, pinch, keys and buttons, moved by the middle button
// or two fingers, and back to the whole by a double click.

const STEP = 1.4;
const WHEEL = 0.0016;
const LINE_PX = 16;

export class View {
  #fingers = new Map();
  #grip = null;

  constructor(stage) {
    this.stage = stage;
    const area = stage.element;
    area.addEventListener("wheel", (event) => this.#roll(event), { passive: false });
    area.addEventListener("pointerdown", (event) => this.#press(event));
    area.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) area.addEventListener(end, (event) => this.#lift(event));
    area.addEventListener("dblclick", () => { if (!stage.tool) stage.show(null); });
    this.#button("zoom-in", () => this.zoom(STEP));
    this.#button("zoom-out", () => this.zoom(1 / STEP));
    this.#button("zoom-fit", () => stage.show(null));
    stage.onResize.push(() => this.#say());
  }

  /** Zoom by a factor around a place of the picture, else around the middle. */
  zoom(factor, around = null) {
    const { view } = this.stage;
    if (!view) return;
    const [x, y] = around ?? [view.x + view.w / 2, view.y + view.h / 2];
    const w = this.stage.allowed(view.w / factor);
    const part = w / view.w;
    this.stage.show({ x: x - (x - view.x) * part, y: y - (y - view.y) * part, w });
  }

  #button(id, act) {
    document.getElementById(id).addEventListener("click", act);
  }

  #say() {
    const { view, width } = this.stage;
    const times = view ? width / view.w : 1;
    document.getElementById("zoom-fit").hidden = times < 1.01;
    document.getElementById("zoom-out").setAttribute("aria-disabled", String(times < 1.01));
    this.stage.element.dataset.zoom = times.toFixed(2);
  }

  #roll(event) {
    if (!this.stage.view) return;
    const pixels = event.deltaMode === 1 ? event.deltaY * LINE_PX : event.deltaY;
    const isWhole = this.stage.view.w >= this.stage.width;
    if (pixels > 0 && isWhole && !event.ctrlKey) return; // nothing left to zoom out of: the page scrolls
    event.preventDefault();
    this.zoom(Math.exp(-pixels * WHEEL), this.stage.pixel(event));
  }

  // Two fingers, or the middle button.

  #press(event) {
    if (event.pointerType === "touch") this.#fingers.set(event.pointerId, event);
    else if (event.button === 1) {
      event.preventDefault(); // no scrolling by the wheel's button
      this.#fingers.set(event.pointerId, event);
      this.stage.element.setPointerCapture(event.pointerId);
    }
    this.#grip = this.#gripped();
  }

  #move(event) {
    if (!this.#fingers.has(event.pointerId)) return;
    this.#fingers.set(event.pointerId, event);
    const now = this.#gripped();
    if (!now || !this.#grip || !this.stage.view) return;
    if (this.#grip.apart) this.zoom(now.apart / this.#grip.apart, this.stage.pixel(now));
    const { view, k } = this.stage;
    this.stage.show({
      x: view.x - (now.clientX - this.#grip.clientX) * k,
      y: view.y - (now.clientY - this.#grip.clientY) * k,
      w: view.w,
    });
    this.#grip = now;
  }

  #lift(event) {
    this.#fingers.delete(event.pointerId);
    this.#grip = this.#gripped();
  }

  /** The middle of two fingers and their distance; the mouse alone is enough. */
  #gripped() {
    const all = [...this.#fingers.values()];
    if (all.length === 1 && all[0].pointerType !== "touch") {
      return { clientX: all[0].clientX, clientY: all[0].clientY, apart: 0 };
    }
    if (all.length !== 2) return null;
    const [a, b] = all;
    return {
      clientX: (a.clientX + b.clientX) / 2,
      clientY: (a.clientY + b.clientY) / 2,
      apart: Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY),
    };
  }
}
