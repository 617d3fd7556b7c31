// The zones' card: the list for everybody; for operators a new zone, edit, rename, move, delete, and
// undo. While it is open, no press in the arena sets a goal.

import { fill } from "./list.js";
import { areaOf, covers } from "./zone_area.js";
import { ZoneForm } from "./zone_form.js";
import { ZoneTool } from "./zone_tool.js";
import { KINDS, rule, zoneSample } from "./zones_layer.js";

const byId = (id) => document.getElementById(id);
const TYPED = "input, select, textarea";

export class Zones {
  #revision = 0;
  #undone = Promise.resolve();
  /** Revision at which two orders were one change for people: a rename. */
  #renamed = -1;
  /** Old and new name of a zone whose rename the program has not reported yet. */
  #renaming = null;

  constructor(stage, connection, seat, layers, layer, fleet) {
    Object.assign(this, { stage, connection, seat, layers, layer });
    this.card = byId("zones");
    this.button = byId("zones-open");
    this.note = byId("zones-note");
    this.list = byId("zones-list");
    this.tool = new ZoneTool(stage, {
      changed: (area) => this.form.take(area),
      done: () => this.form.submit(),
      cancelled: () => this.escape(),
      picked: (x, y) => this.#pick(x, y),
    });
    this.form = new ZoneForm(this.tool, fleet, {
      names: () => layer.zones.map(({ name }) => name),
      save: (zone, before) => this.#save(zone, before),
      cancel: () => this.#leaveForm(""),
    });
    this.button.addEventListener("click", () => this.toggle());
    byId("zones-close").addEventListener("click", () => this.toggle());
    byId("zones-new").addEventListener("click", () => this.#edit(null));
    byId("zones-undo").addEventListener("click", () => this.undo());
    this.card.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !event.target.matches(TYPED)) return; // main.js has the others
      event.stopPropagation();
      this.escape();
    });
    addEventListener("keydown", (event) => this.#key(event));
    connection.on("zones", (message) => this.#hear(message));
    connection.on("hello", (hello) => { this.form.radius_m = hello.robot.radius_m; this.#show(); });
    for (const sample of document.querySelectorAll("svg[data-zone]")) sample.append(...zoneSample(sample.dataset.zone));
  }

  get isOpen() {
    return !this.card.hidden;
  }

  get #mayChange() {
    return !this.seat.mayNot;
  }

  toggle() {
    const on = !this.isOpen;
    if (!on) this.#leaveForm("");
    this.card.hidden = !on;
    this.button.setAttribute("aria-expanded", String(on));
    document.body.classList.toggle("is-zoning", on);
    this.tool.isOn = on;
    this.#say("");
    if (!on) {
      this.layer.mark("");
      this.button.focus();
      return;
    }
    this.layers.show("zones");
    this.#show();
    byId(this.#mayChange ? "zones-new" : "zones-close").focus();
  }

  escape() {
    if (this.form.isOpen) this.#leaveForm("");
    else this.toggle();
  }

  /** Enter, without a focus. */
  enter() {
    if (this.form.isOpen) this.form.submit();
  }

  undo() {
    this.#undone = this.#undone.then(() => this.#undoOne()); // a second press waits for the first
    return this.#undone;
  }

  /** Take back the newest change that this page has heard of, and none that is newer. */
  async #undoOne() {
    const orders = this.#revision === this.#renamed ? 2 : 1;
    let answer = { ok: true };
    for (let n = 0; n < orders && answer.ok; n++) {
      answer = await this.#order("zone_undo", { revision: this.#revision });
    }
    this.#say(answer.ok ? `the last change is taken back${troubleOf(answer)}` : answer.error, !answer.ok);
  }

  #key(event) {
    if (!this.isOpen || !(event.ctrlKey || event.metaKey) || event.shiftKey || event.key.toLowerCase() !== "z") return;
    if (event.target.matches("input[type=text], textarea")) return; // what was typed is taken back
    event.preventDefault();
    if (this.form.isOpen) this.tool.undo();
    else if (this.#mayChange) this.undo();
  }

  async #order(order, fields = {}) {
    if (this.seat.mayNot) return { ok: false, error: this.seat.mayNot };
    const taken = await this.seat.takeIfFree();
    if (!taken.ok) return taken;
    const answer = await this.connection.ask({ type: "order", order, robot: null, ...fields });
    if (answer.ok) this.#revision++; // the zones of it may come later
    return answer;
  }

  #hear({ revision, zones }) {
    this.#revision = revision;
    const names = new Set(zones.map(({ name }) => name));
    if (this.#renaming && names.has(this.#renaming[1]) && !names.has(this.#renaming[0])) {
      this.#renamed = revision;
      this.#renaming = null;
    }
    this.#show();
  }

  // One zone.

  #edit(zone) {
    this.#say("");
    this.layer.mark("");
    this.layer.hide(zone?.name ?? "");
    byId("zones-all").hidden = true;
    this.form.open(zone);
  }

  #leaveForm(said) {
    if (!this.form.isOpen) return;
    this.form.close();
    this.layer.hide("");
    byId("zones-all").hidden = false;
    this.#say(said);
    byId("zones-new").focus({ preventScroll: true });
  }

  /** A new zone, or one in place of the zone named `before`; the reason if it is refused, or "". */
  async #save(zone, before) {
    const isRenamed = before && before !== zone.name;
    const answer = await this.#order("zone_put", { zone });
    if (!answer.ok) return answer.error;
    if (isRenamed) {
      this.#renaming = [before, zone.name];
      const removed = await this.#order("zone_remove", { name: before });
      if (!removed.ok) return removed.error;
    }
    this.#leaveForm(`${zone.name} is in force${troubleOf(answer)}`);
    return "";
  }

  async #remove({ name }) {
    const answer = await this.#order("zone_remove", { name });
    this.#say(answer.ok ? `${name} is removed${troubleOf(answer)}` : answer.error, !answer.ok);
    if (answer.ok) byId("zones-undo").focus({ preventScroll: true });
  }

  #pick(x, y) {
    const zone = this.layer.zones.findLast((one) => covers(areaOf(one), x, y));
    if (!zone) this.layer.mark("");
    else if (this.#mayChange && !zone.mask) this.#edit(zone);
    else {
      this.layer.mark(zone.name);
      this.#say(`${zone.name}: ${rule(zone)}.`);
    }
  }

  // What is shown.

  #say(text, isBad = false) {
    this.note.textContent = text ? text[0].toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? "" : ".") : "";
    this.note.classList.toggle("bad", isBad);
  }

  #show() {
    byId("zones-count").textContent = String(this.layer.zones.length);
    if (!this.isOpen) return;
    byId("zones-orders").hidden = !this.#mayChange;
    byId("zones-none").hidden = this.layer.zones.length > 0;
    const sorted = [...this.layer.zones].sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true }));
    fill(this.list, [sorted, this.#mayChange], () => sorted.map((zone) => this.#row(zone)));
  }

  #row(zone) {
    const row = document.createElement("li");
    const sample = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    sample.setAttribute("viewBox", "0 0 40 16");
    sample.setAttribute("aria-hidden", "true");
    sample.append(...zoneSample(zone.kind));
    const whose = zone.robots?.length ? `; for ${zone.robots.join(", ")}` : "";
    const from = zone.mask ? `; from ${zone.mask}` : "";
    const words = document.createElement("p");
    words.append(made("strong", zone.name), made("small", `${zone.kind === "slow" ? "slow, " : ""}${rule(zone)}${whose}${from}`));
    row.append(sample, words);
    if (this.#mayChange) {
      if (!zone.mask) row.append(button("Edit", `Edit ${zone.name}`, () => this.#edit(zone)));
      row.append(button("×", `Delete ${zone.name}`, () => this.#remove(zone)));
    }
    row.title = `${KINDS[zone.kind]}: ${zone.name}`;
    row.addEventListener("pointerenter", () => this.layer.mark(zone.name));
    row.addEventListener("pointerleave", () => this.layer.mark(""));
    row.addEventListener("focusin", () => this.layer.mark(zone.name));
    row.addEventListener("focusout", () => this.layer.mark(""));
    return row;
  }
}

const troubleOf = ({ trouble }) => (trouble ? `, but ${trouble}` : "");

const made = (tag, textContent) => Object.assign(document.createElement(tag), { textContent });

function button(text, label, act) {
  const one = Object.assign(made("button", text), { type: "button", className: "quiet small", title: label });
  one.setAttribute("aria-label", label);
  one.addEventListener("click", act);
  return one;
}
