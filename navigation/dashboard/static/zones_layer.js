// Zones in the arena: each kind has a colour, a pattern and words.

import { along, areaOf } from "./zone_area.js";
import { element } from "./stage.js";
import { middleOf } from "./world.js";

export const KINDS = { keep_out: "Keep out", slow: "Slow", one_way: "One way", lane: "Lane", wait: "No waiting" };
/** Kinds whose area is a band: its line gives the direction. */
export const BANDS_ONLY = ["one_way", "lane"];
const PATTERNS = {
  "keep-out": ["45", 8, "M-1 4H9"],
  wait: ["-45", 14, "M-1 7H15"],
  slow: ["0", 9, "M2 2h0M6.5 6.5h0"],
};
const ARROW_PX = 26;

export class ZonesLayer {
  #zones = [];
  #hidden = "";
  #marked = "";
  #said = "";

  constructor(stage, connection) {
    this.stage = stage;
    this.#makePatterns();
    connection.on("zones", ({ zones }) => { this.#zones = zones; this.#draw(); });
    connection.on("state", ({ mission }) => this.#heed([mission.sentence, ...mission.reasons].join("\n")));
    stage.onResize.push(() => this.#draw());
  }

  get zones() {
    return this.#zones;
  }

  /** Draw one of them by name stronger than the others; "" for none. */
  mark(name) {
    this.#marked = name;
    this.#applyMarks();
  }

  /** Leave out one of them, which is drawn elsewhere as it is changed; "" for none. */
  hide(name) {
    this.#hidden = name;
    this.#draw();
  }

  /** Zones that a sentence names are drawn stronger. */
  #heed(said) {
    if (said === this.#said) return;
    this.#said = said;
    this.#applyMarks();
  }

  #applyMarks() {
    for (const group of this.stage.group("zones").children) {
      const { name, title } = group.dataset;
      group.classList.toggle("is-marked", name === this.#marked || this.#said.includes(title));
    }
  }

  #draw() {
    if (!this.stage.window) return;
    for (const pattern of this.stage.svg.querySelectorAll("pattern")) {
      pattern.setAttribute("patternTransform", `scale(${this.stage.k}) rotate(${pattern.dataset.turn})`);
    }
    const shown = this.#zones.filter(({ name }) => name !== this.#hidden);
    this.stage.group("zones").replaceChildren(...shown.map((zone, n) => {
      const group = zoneShape(this.stage, zone, areaOf(zone), `zone-edge-${n}`);
      Object.assign(group.dataset, { name: zone.name, title: zone.title });
      return group;
    }));
    this.stage.group("zone-names").replaceChildren(...shown.map((zone) => zoneName(this.stage, zone, areaOf(zone))));
    this.#applyMarks();
  }

  #makePatterns() {
    const made = Object.entries(PATTERNS).map(([kind, [turn, size, d]]) => {
      const pattern = element("pattern", { id: `zone-${kind}`, width: size, height: size, patternUnits: "userSpaceOnUse", "data-turn": turn });
      pattern.append(element("path", { class: `zone-${kind} zone-ink`, d }));
      return pattern;
    });
    const defs = element("defs");
    defs.append(...made);
    this.stage.svg.prepend(defs);
  }
}

export function rule({ kind, speed_m_s, cost }) {
  const words = [];
  if (kind !== "slow") words.push(KINDS[kind].toLowerCase());
  if (speed_m_s) words.push(`max ${speed_m_s} m/s`);
  if (cost) words.push(`cost ${cost}`);
  return words.join(", ");
}

const cssOf = (kind) => kind.replace("_", "-");

/** A zone's area with its pattern and edge; `id` is its own on the page. */
export function zoneShape(stage, { kind }, area, id) {
  const group = element("g", { class: `zone zone-${cssOf(kind)}` });
  const pattern = PATTERNS[cssOf(kind)] ? `url(#zone-${cssOf(kind)})` : null;
  if (area.shape === "line") group.append(...band(stage, area, pattern, id));
  else {
    const d = outline(stage, area);
    group.append(element("path", { class: "zone-tint", d, "fill-rule": "evenodd" }));
    if (pattern) group.append(element("path", { class: "zone-pattern", d, "fill-rule": "evenodd" }));
    if (pattern) group.lastChild.style.fill = pattern; // a rule of the style is stronger than an attribute
    group.append(element("path", { class: "zone-edge", d }));
  }
  if (kind === "one_way") group.append(...arrows(stage, area));
  if (kind === "lane") group.append(element("path", { class: "zone-middle", d: stage.line(area.points.flat()) }));
  return group;
}

function outline(stage, area) {
  if (area.shape !== "circle") return (area.outlines ?? [area.points]).map((ring) => `${stage.line(ring.flat())}Z`).join("");
  const [[x, y]] = area.points;
  const r = area.radius_m * stage.scale;
  return `M${stage.x(x) - r} ${stage.y(y)}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0Z`;
}

/** All places within half the width of the line; its edge is what a wider stroke has more. */
function band(stage, { points, width_m }, pattern, id) {
  const d = stage.line(points.flat());
  const wide = width_m * stage.scale;
  const rim = 2 * stage.k;
  const mask = element("mask", { id, maskUnits: "userSpaceOnUse", x: 0, y: 0, width: stage.width, height: stage.height });
  mask.append(
    element("rect", { width: stage.width, height: stage.height, fill: "#fff" }),
    element("path", { class: "zone-hole", d, "stroke-width": Math.max(0, wide - rim) }),
  );
  return [
    mask,
    element("path", { class: "zone-band", d, "stroke-width": wide }),
    ...(pattern ? [element("path", { class: "zone-band-pattern", d, stroke: pattern, "stroke-width": wide })] : []),
    element("path", { class: "zone-rim", d, "stroke-width": wide + rim, mask: `url(#${id})` }),
  ];
}

function arrows(stage, { points, width_m }) {
  const size = Math.min(0.3 * width_m * stage.scale, 11 * stage.k);
  const d = along(points, Math.max((ARROW_PX * stage.k) / stage.scale, 0.9 * width_m)).map(([x, y, angle]) => {
    const at = (ahead, aside) => {
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      return `${(stage.x(x) + ahead * c - aside * s).toFixed(1)} ${(stage.y(y) - ahead * s - aside * c).toFixed(1)}`;
    };
    return `M${at(-size, size)}L${at(size, 0)}L${at(-size, -size)}`;
  }).join("");
  return [element("path", { class: "zone-arrow-halo", d }), element("path", { class: "zone-arrow", d })];
}

/**
 * A zone's name and rule: in its middle if they fit, else the name alone, there or below it, with the
 * speed of a slow one; kept within the picture.
 */
export function zoneName(stage, zone, area) {
  const { k } = stage;
  const box = boxOf(stage, area);
  const halfOf = (text) => (text.length * 3.7 + 4) * k;
  const both = Math.max(halfOf(zone.name), halfOf(rule(zone)));
  const isRoomy = box.wide > 2 * both && box.high > 40 * k;
  const name = !isRoomy && zone.kind === "slow" && zone.speed_m_s ? `${zone.name}, ${rule(zone)}` : zone.name;
  const fits = isRoomy || (box.wide > 2 * halfOf(name) && box.high > 20 * k);
  const half = isRoomy ? both : halfOf(name);
  const x = box.x + Math.max(half - box.x, 0) - Math.max(box.x + half - stage.width, 0);
  const below = box.y + box.high / 2 + 14 * k;
  const isLow = below + 4 * k > stage.height;
  const y = isRoomy ? box.y - 3 * k : fits ? box.y + 4.5 * k : isLow ? box.y - box.high / 2 - 6 * k : below;
  const group = element("g", { class: `zone-name zone-${cssOf(zone.kind)}` });
  if (isRoomy) group.append(element("text", { class: "label zone-rule", x, y: y + 16 * k, "text-anchor": "middle" }, rule(zone)));
  group.append(element("text", { class: "label", x, y, "text-anchor": "middle" }, name));
  return group;
}

/** Place of a zone's words, and the room there, in the picture's pixels. */
function boxOf(stage, area) {
  if (area.shape === "line") {
    const [x, y, angle] = along(area.points, Infinity)[0] ?? [...area.points[0], 0];
    const wide = area.width_m * stage.scale;
    const isFlat = Math.abs(Math.cos(angle)) > 0.9;
    return { x: stage.x(x), y: stage.y(y), wide: isFlat ? spread(area.points) * stage.scale : wide, high: wide };
  }
  if (area.shape === "circle") {
    const [[x, y]] = area.points;
    const r = area.radius_m * stage.scale;
    return { x: stage.x(x), y: stage.y(y), wide: 1.7 * r, high: 2 * r };
  }
  const ring = (area.outlines ?? [area.points]).reduce((best, one) => (spread(one) > spread(best) ? one : best));
  const { x, y } = middleOf(ring);
  const heights = ring.map((point) => point[1]);
  const high = (Math.max(...heights) - Math.min(...heights)) * stage.scale;
  return { x: stage.x(x), y: stage.y(y), wide: spread(ring) * stage.scale, high };
}

function spread(ring) {
  const across = ring.map(([x]) => x);
  return Math.max(...across) - Math.min(...across);
}

/** A kind's sample for the legend and the list, 40 by 16. */
export function zoneSample(kind) {
  const shapes = {
    keep_out: [["zone-ink", "M4 14L16 2M12 14L24 2M20 14L32 2M28 14L38 4"]],
    slow: [["zone-ink", "M9 5.5h0M15 10.5h0M20 5.5h0M26 10.5h0M31 5.5h0"]],
    one_way: [["zone-arrow", "M9 4.5L13 8L9 11.5M19 4.5L23 8L19 11.5M29 4.5L33 8L29 11.5"]],
    lane: [["zone-middle", "M4 8H36"]],
    wait: [["zone-ink", "M4 4L12 12M15 4L23 12M26 4L34 12"]],
  }[kind];
  const group = element("g", { class: `zone zone-${cssOf(kind)}` });
  const box = "M2 2H38V14H2Z";
  group.append(element("path", { class: "zone-tint", d: box }), ...shapes.map(([name, d]) => element("path", { class: name, d })), element("path", { class: "zone-edge", d: box }));
  return [group];
}
