// A zone drawn in the arena: corners by clicks, a circle by its centre and a drag; then corners, or the
// whole, dragged. While the tool is on, no press and no key of the arena reaches a goal.

import { FEWEST, covers, moved, round } from "./zone_area.js";
import { element } from "./stage.js";
import { zoneName, zoneShape } from "./zones_layer.js";

const HOLD_PX = 13;
const DRAG_PX = 5;
const MOST_CORNERS = 100; // of a line the program takes no more

export class ZoneTool {
  /** {zone, area, isOpen} with the zone as it is written, or null. */
  #draft = null;
  /** Areas before each change, for undo. */
  #before = [];
  #pressed = null;
  #pointer = null;

  /** `heard`: changed(area), done(), cancelled(), picked(x, y, metres). */
  constructor(stage, heard) {
    Object.assign(this, { stage, heard });
    this.probe = document.getElementById("probe");
    const area = stage.element;
    this.words = area.getAttribute("aria-label");
    area.addEventListener("pointerdown", (event) => this.#if(() => this.#press(event)));
    area.addEventListener("pointermove", (event) => this.#if(() => this.#move(event)));
    area.addEventListener("pointerup", (event) => this.#if(() => this.#lift(event)));
    area.addEventListener("pointercancel", () => this.#if(() => this.#letGo()));
    area.addEventListener("pointerleave", () => this.#if(() => { this.#pointer = null; this.#draw(); }));
    area.addEventListener("dblclick", () => this.#if(() => this.close()));
    area.addEventListener("keydown", (event) => this.#if(() => this.#key(event)));
    stage.onResize.push(() => this.#draw());
  }

  get isOn() {
    return this.stage.tool === this;
  }

  get area() {
    return this.#draft?.area ?? null;
  }

  get isWhole() {
    return Boolean(this.#draft) && this.area.points.length >= FEWEST[this.area.shape] && (this.area.shape !== "circle" || this.area.radius_m > 0);
  }

  set isOn(on) {
    this.stage.tool = on ? this : null;
    this.stage.element.setAttribute("aria-label", on ? "The arena from above, for zones. Click to set corners, drag to move them; Enter closes a zone, Backspace takes the last change back, Escape cancels. A form beside takes the same as numbers." : this.words);
    this.stage.group("probe").replaceChildren();
    this.stage.element.style.cursor = "";
    if (!on) this.end();
  }

  begin(zone, area) {
    this.#draft = { zone, area, isOpen: !area.points.length };
    this.#before = [];
    this.#draw();
  }

  end() {
    this.#draft = this.#pressed = null;
    this.#before = [];
    this.#draw();
  }

  show(zone, area) {
    if (!this.#draft) return;
    this.#draft.zone = zone;
    this.#draft.area = area;
    if (!area.points.length) this.#draft.isOpen = true;
    this.#draw();
  }

  /** End the corners, if there are enough. */
  close() {
    if (!this.#draft?.isOpen || !this.isWhole) return;
    this.#draft.isOpen = false;
    this.#draw();
  }

  /** Take the last change of the area back; true if there was one. */
  undo() {
    if (!this.#before.length) return false;
    Object.assign(this.#draft, this.#before.pop());
    this.#draw();
    this.heard.changed(this.area);
    return true;
  }

  #if(act) {
    if (this.isOn) act();
  }

  #change(area, isOpen = this.#draft.isOpen) {
    this.#before.push({ area: this.area, isOpen: this.#draft.isOpen });
    Object.assign(this.#draft, { area, isOpen });
    this.#draw();
    this.heard.changed(area);
  }

  // The pointer.

  #press(event) {
    if (!event.isPrimary) { // a second finger moves the view
      this.#letGo();
      return;
    }
    if (event.button !== 0) return;
    event.preventDefault();
    this.stage.element.focus({ preventScroll: true });
    this.stage.element.setPointerCapture(event.pointerId);
    const [x, y] = this.stage.place(event);
    this.#pressed = { from: [x, y], px: [event.clientX, event.clientY], isDrag: false, held: this.#held(x, y) };
  }

  /** Target of a press: a corner's number, "whole", "rim" of a circle, or "" for a new corner. */
  #held(x, y) {
    if (!this.#draft) return "";
    const { area, isOpen } = this.#draft;
    const reach = (HOLD_PX * this.stage.k) / this.stage.scale;
    const corner = area.points.findLastIndex(([px, py]) => Math.hypot(px - x, py - y) < reach);
    if (area.shape === "circle" && !isOpen) {
      const off = Math.hypot(area.points[0][0] - x, area.points[0][1] - y);
      if (Math.abs(off - area.radius_m) < reach) return "rim";
      return off < area.radius_m ? "whole" : "";
    }
    if (corner >= 0) return corner;
    return !isOpen && covers(area, x, y) ? "whole" : "";
  }

  #move(event) {
    const place = this.stage.place(event);
    this.probe.textContent = `x ${place[0].toFixed(3)}  y ${place[1].toFixed(3)} m`;
    this.probe.classList.remove("bad");
    this.#pointer = event.pointerType === "touch" ? null : place;
    const pressed = this.#pressed;
    this.stage.element.style.cursor = (pressed?.held ?? this.#held(...place)) === "" ? "" : "move";
    if (pressed) {
      pressed.isDrag ||= Math.hypot(event.clientX - pressed.px[0], event.clientY - pressed.px[1]) > DRAG_PX;
      pressed.to = place;
    }
    if (this.#draft) this.#draw();
  }

  #lift(event) {
    const pressed = this.#pressed;
    this.#pressed = null;
    if (!pressed || event.button !== 0) return;
    const place = this.stage.place(event);
    if (!this.#draft) {
      if (!pressed.isDrag) this.heard.picked(...place);
      return;
    }
    const { area, isOpen } = this.#draft;
    const next = pressed.isDrag ? this.#dragged({ ...pressed, to: place }) : null;
    if (next) this.#change(next, isOpen && area.shape !== "circle");
    else if (pressed.held === 0 && isOpen && area.shape === "polygon") this.close(); // on the first corner
    else if (pressed.held === "" && isOpen) this.#add(place);
    this.#draw();
  }

  #add([x, y]) {
    const { area } = this.#draft;
    if (area.points.length >= MOST_CORNERS) return;
    const corner = [round(x), round(y)];
    if (area.shape === "circle") this.#change({ ...area, points: [corner] }, false);
    else this.#change({ ...area, points: [...area.points, corner] });
  }

  /** The area as a drag makes it; null if it moves nothing. */
  #dragged({ held, from, to }) {
    const { area, isOpen } = this.#draft;
    const [x, y] = to.map(round);
    if (area.shape === "circle" && isOpen) {
      return { ...area, points: [from.map(round)], radius_m: this.#radius(from, to) };
    }
    if (held === "rim") return { ...area, radius_m: this.#radius(area.points[0], to) };
    if (held === "whole") return moved(area, to[0] - from[0], to[1] - from[1]);
    if (typeof held !== "number") return null;
    return { ...area, points: area.points.map((point, n) => (n === held ? [x, y] : point)) };
  }

  #radius([x, y], to) {
    return Math.max(0.001, round(Math.hypot(to[0] - x, to[1] - y)));
  }

  #letGo() {
    this.#pressed = null;
    this.#draw();
  }

  // The keyboard.

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Enter" && this.#draft) {
      if (this.#draft.isOpen) this.close();
      else this.heard.done();
    } else if (event.key === "Backspace") this.undo();
    else if (event.key === "Escape") this.heard.cancelled();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  // What is drawn.

  #draw() {
    const group = this.stage.group("zone-draft");
    if (!this.#draft || !this.stage.window) {
      group.replaceChildren();
      return;
    }
    const { zone, isOpen } = this.#draft;
    const pressed = this.#pressed;
    const area = (pressed?.isDrag && this.#dragged(pressed)) || this.area;
    const next = isOpen && area.shape !== "circle" && this.#pointer && !pressed?.isDrag ? [this.#pointer] : [];
    const shown = { ...area, points: [...area.points, ...next] };
    const isDrawn = shown.points.length >= (area.shape === "circle" ? 1 : 2);
    const shapes = [];
    if (isDrawn) {
      shapes.push(zoneShape(this.stage, zone, shown, "zone-edge-draft"));
      if (shown.points.length >= FEWEST[area.shape]) shapes.push(zoneName(this.stage, zone, shown));
    }
    if (area.shape === "line" && isDrawn) shapes.push(element("path", { class: "zone-line", d: this.stage.line(shown.points.flat()) }));
    shapes.push(...area.points.map(([x, y], n) => this.#handle(x, y, isOpen && n === 0 && area.shape === "polygon" && area.points.length > 2)));
    if (area.shape === "circle" && area.points.length) shapes.push(this.#handle(area.points[0][0] + area.radius_m, area.points[0][1], false));
    group.replaceChildren(...shapes);
    group.setAttribute("class", isOpen ? "is-open" : "");
  }

  #handle(x, y, closes) {
    const r = (closes ? 8 : 5.5) * this.stage.k;
    return element("circle", { class: "zone-handle", cx: this.stage.x(x), cy: this.stage.y(y), r });
  }
}
