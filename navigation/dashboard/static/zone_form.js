// One zone as numbers and words, beside the arena where it is drawn: each follows the other.

import { allow } from "./press.js";
import { FEWEST, SHAPES, areaOf, asText, fromText, short, written } from "./zone_area.js";
import { BANDS_ONLY, KINDS } from "./zones_layer.js";

const byId = (id) => document.getElementById(id);
const NAME = /^[A-Za-z][A-Za-z0-9_-]{0,31}$/;
/** Keys of the form; a zone's others are kept as they are. */
const SAID = ["title", "outlines", "mask", "name", "kind", "polygon", "circle", "line", "width_m", "robots", "speed_m_s", "cost"];
const HINTS = {
  polygon: "Click its corners in the arena; Enter or a double click closes it.",
  circle: "Press at its centre in the arena, and drag to its rim.",
  line: "Click along its middle in the arena; Enter or a double click ends it.",
};
const DONE = "Drag a corner, or the whole, to move it.";
const NEEDS = {
  polygon: "it needs three corners or more: click them in the arena, or type them",
  circle: "it needs a centre and a radius: drag them in the arena, or type them",
  line: "it needs two places or more: click them in the arena, or type them",
};

export class ZoneForm {
  #zone = null;
  #area = null;
  #isNamed = false;
  #isSaving = false;

  /** `asked`: names() of all zones, save(zone, before) -> why not, cancel(). */
  constructor(tool, fleet, asked) {
    Object.assign(this, { tool, fleet, asked });
    this.form = byId("zone-form");
    /** The robot's, for the size of a new zone. */
    this.radius_m = 0.1;
    for (const [id, names] of [["zone-kind", KINDS], ["zone-shape", SHAPES]]) {
      byId(id).append(...Object.entries(names).map(([value, text]) => new Option(text, value)));
    }
    byId("zone-kind").addEventListener("change", () => this.#changeKind());
    byId("zone-shape").addEventListener("change", () => this.#changeShape());
    byId("zone-name").addEventListener("input", () => { this.#isNamed = true; });
    this.form.addEventListener("input", () => this.#read());
    this.form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.submit();
    });
    byId("zone-back").addEventListener("click", () => this.tool.undo());
    byId("zone-cancel").addEventListener("click", () => asked.cancel());
  }

  get isOpen() {
    return !this.form.hidden;
  }

  open(zone) {
    this.#zone = zone;
    this.#isNamed = Boolean(zone);
    this.#isSaving = false;
    const wide = Math.ceil(60 * this.radius_m) / 20; // three radii, to 5 cm
    this.#area = { radius_m: wide, width_m: wide, ...(zone ? areaOf(zone) : { shape: "polygon", points: [] }) };
    this.form.hidden = false;
    byId("zones-title").textContent = zone ? `Edit ${zone.name}` : "New zone";
    byId("zone-kind").value = zone?.kind ?? "keep_out";
    byId("zone-name").value = zone?.name ?? this.#suggestion;
    byId("zone-speed").value = zone?.speed_m_s ?? "";
    byId("zone-cost").value = zone?.cost ?? "";
    this.#showRobots(zone?.robots ?? []);
    this.#complain("");
    this.#fill();
    this.tool.begin(this.#words, this.#area);
    this.#show();
    byId("zone-kind").focus({ preventScroll: true });
  }

  close() {
    this.form.hidden = true;
    byId("zones-title").textContent = "Zones";
    this.tool.end();
  }

  take(area) {
    this.#area = area;
    this.#complain("");
    this.#fill();
    this.#show();
  }

  async submit() {
    if (this.#missing || this.#isSaving) {
      if (this.#missing) this.#complain(this.#missing);
      return;
    }
    this.tool.close();
    this.#isSaving = true;
    this.#complain(await this.asked.save(this.#whole, this.#zone?.name ?? ""));
    this.#isSaving = false;
  }

  get #suggestion() {
    const base = byId("zone-kind").value.replace("_", "-");
    const names = this.asked.names();
    let number = 1;
    while (names.includes(`${base}-${number}`)) number += 1;
    return `${base}-${number}`;
  }

  /** The zone but for its area, as a configuration has it. */
  get #words() {
    const kind = byId("zone-kind").value;
    const [speed, cost] = [number("zone-speed"), number("zone-cost")];
    const robots = [...this.form.querySelectorAll("[name=zone-robot]:checked")].map(({ value }) => value);
    return {
      name: byId("zone-name").value.trim(), kind,
      ...(kind !== "keep_out" && speed !== null ? { speed_m_s: speed } : {}),
      ...(kind === "lane" && cost !== null ? { cost } : {}),
      ...(robots.length ? { robots } : {}),
    };
  }

  get #whole() {
    const kept = Object.entries(this.#zone ?? {}).filter(([key]) => !SAID.includes(key));
    return { ...Object.fromEntries(kept), ...this.#words, ...written(this.#area) };
  }

  /** Reason why it cannot be saved yet, or "". */
  get #missing() {
    const { name, kind, speed_m_s: speed, cost } = this.#words;
    const { shape, points, radius_m, width_m } = this.#area;
    if (fromText(byId("zone-places").value) === null) return "each line must be a place: x, y in metres";
    if (points.length < FEWEST[shape]) return NEEDS[shape];
    if (shape === "circle" && !(radius_m > 0)) return "the radius must be > 0";
    if (shape === "line" && !(width_m > 0)) return "the width must be > 0";
    if (!NAME.test(name)) return "the name must be a letter, then letters, digits, _ and -, at most 32";
    if (name !== this.#zone?.name && this.asked.names().includes(name)) return `there is a zone '${name}' already`;
    if (Number.isNaN(speed) || (kind === "slow" && !(speed > 0))) return "the speed must be a number > 0, in m/s";
    if (Number.isNaN(cost)) return "the cost must be a number from 0.05 to 1";
    return "";
  }

  #changeKind() {
    if (BANDS_ONLY.includes(byId("zone-kind").value) && this.#area.shape !== "line") this.#become("line");
    if (!this.#isNamed) byId("zone-name").value = this.#suggestion;
    this.#read();
  }

  #changeShape() {
    this.#become(byId("zone-shape").value);
    this.#read();
  }

  /** Corners stay where polygon and band exchange them; a circle begins again. */
  #become(shape) {
    const isRound = shape === "circle" || this.#area.shape === "circle";
    this.#area = { ...this.#area, shape, points: isRound ? [] : this.#area.points };
    this.#fill();
  }

  /** Typed values, as far as they can be drawn. */
  #read() {
    const points = fromText(byId("zone-places").value);
    byId("zone-places").setAttribute("aria-invalid", String(points === null));
    const size = number("zone-size");
    const key = this.#area.shape === "circle" ? "radius_m" : "width_m";
    const isCircle = this.#area.shape === "circle";
    this.#area = {
      ...this.#area,
      points: points === null ? this.#area.points : isCircle ? points.slice(0, 1) : points,
      ...(this.#area.shape === "polygon" ? {} : { [key]: size > 0 ? size : 0 }),
    };
    this.tool.show(this.#words, this.#area);
    this.#complain("");
    this.#show();
  }

  #fill() {
    const { shape, points, radius_m, width_m } = this.#area;
    byId("zone-shape").value = shape;
    byId("zone-places").value = asText(points);
    byId("zone-places").removeAttribute("aria-invalid");
    byId("zone-size").value = shape === "circle" ? short(radius_m) : short(width_m);
  }

  #show() {
    const kind = byId("zone-kind").value;
    const { shape } = this.#area;
    for (const option of byId("zone-shape").options) option.disabled = BANDS_ONLY.includes(kind) && option.value !== "line";
    byId("zone-speed-row").hidden = kind === "keep_out";
    byId("zone-speed").placeholder = kind === "slow" ? "" : "no limit";
    byId("zone-cost-row").hidden = kind !== "lane";
    byId("zone-size-row").hidden = shape === "polygon";
    byId("zone-size-title").textContent = shape === "circle" ? "Radius, m" : "Width, m";
    byId("zone-places-title").textContent = { polygon: "Corners", circle: "Centre", line: "Line" }[shape] + ": x, y in m";
    byId("zone-places").rows = shape === "circle" ? 1 : 3;
    byId("zone-hint").textContent = this.tool.isWhole ? DONE : HINTS[shape];
    allow(byId("zone-save"), this.#missing);
  }

  #showRobots(chosen) {
    const names = this.fleet.robots.map(({ name }) => name);
    byId("zone-robots").hidden = names.length === 0;
    byId("zone-robots-list").replaceChildren(...names.map((name) => {
      const label = document.createElement("label");
      const input = Object.assign(document.createElement("input"), { type: "checkbox", name: "zone-robot", value: name, checked: chosen.includes(name) });
      label.append(input, name);
      return label;
    }));
  }

  #complain(text) {
    byId("zone-hint").hidden = Boolean(text);
    byId("zone-error").textContent = text ? text[0].toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? "" : ".") : "";
    if (text) byId("zone-error").scrollIntoView({ block: "nearest" });
  }
}

/** A field as a number; null if it is empty, NaN if it is none. */
function number(id) {
  const text = byId(id).value.trim().replace(",", ".");
  return text ? Number(text) : null;
}
