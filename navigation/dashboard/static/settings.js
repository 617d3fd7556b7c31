// The configuration as a form: checked as it is typed, saved by the person in control. It is not modal:
// STOP stays where it is, and works.

import { fill } from "./list.js";
import { allow, onPress } from "./press.js";
import { request } from "./request.js";

const CHECK_AFTER_MS = 350;

export class Settings {
  #form = null;
  /** Typed text by key, without fields that were put back. */
  #typed = new Map();
  #problems = new Map();
  #timer = 0;
  #round = 0;

  constructor(connection, seat) {
    Object.assign(this, { connection, seat });
    this.box = byId("settings");
    this.open = byId("settings-open");
    this.open.addEventListener("click", () => this.toggle());
    byId("settings-close").addEventListener("click", () => this.close());
    byId("settings-find").addEventListener("input", () => this.#find());
    onPress(byId("settings-save"), (text) => this.#say(text), () => this.#save());
    onPress(byId("settings-undo"), (text) => this.#say(text), () => this.#undo());
    connection.on("hello", () => { this.open.hidden = !seat.mayDrive; });
    connection.on("up", () => { if (this.isOpen && this.#typed.size === 0) this.#load(); });
  }

  get isOpen() {
    return !this.box.hidden;
  }

  toggle() {
    this.box.hidden = !this.box.hidden;
    this.open.setAttribute("aria-expanded", String(this.isOpen));
    if (this.isOpen) {
      byId("settings-close").focus();
      this.#say("");
      if (this.#typed.size === 0) this.#load();
    } else {
      this.open.focus();
    }
  }

  close() {
    if (this.isOpen) this.toggle();
  }

  async #load() {
    const answer = await request(this.connection, "/api/settings");
    if (!answer.ok) {
      this.#say(answer.error);
      return;
    }
    const isNew = fill(byId("settings-sections"), answer, () => answer.sections.map((section) => this.#section(section)));
    if (!isNew) return; // it may be read or typed in
    this.#form = answer;
    this.#typed.clear();
    this.#problems.clear();
    byId("settings-file").textContent = answer.file;
    this.#find();
    this.#show();
  }

  #section(section) {
    const box = document.createElement("details");
    box.open = !section.of_several && section.keys.some((key) => key.value !== "" && !key.only_shown);
    const title = make("summary", "", section.name);
    title.append(make("span", "hint", ` ${section.meaning}`));
    box.append(title, ...section.keys.map((key) => this.#row(key, section.name)));
    return box;
  }

  #row(key, section) {
    const row = make("div", "setting");
    row.dataset.key = key.key;
    row.dataset.words = `${section} ${key.key} ${key.meaning}`.toLowerCase();
    const label = make("label", "", key.key.split(".").slice(1).join(".") || key.key);
    const id = `setting-${key.key}`;
    const control = key.only_shown ? shown(key) : field(key);
    control.id = id;
    label.htmlFor = id;
    const hint = make("p", "hint", key.only_shown ? `${key.meaning}. (${key.only_shown})` : `${key.meaning}${limits(key)}`);
    hint.id = `${id}-hint`;
    const problem = make("p", "problem");
    problem.id = `${id}-problem`;
    control.setAttribute("aria-describedby", `${hint.id} ${problem.id}`);
    if (!key.only_shown) {
      control.addEventListener(control.tagName === "SELECT" ? "change" : "input", () => this.#type(key, control.value));
    }
    row.append(label, control, hint, problem);
    return row;
  }

  #type(key, words) {
    if (words.trim() === key.value) this.#typed.delete(key.key);
    else this.#typed.set(key.key, words);
    this.#say("");
    clearTimeout(this.#timer);
    this.#timer = setTimeout(() => this.#check(), CHECK_AFTER_MS);
    this.#show("checking");
  }

  async #check() {
    const round = ++this.#round;
    const answer = await request(this.connection, "/api/settings/check", { changes: Object.fromEntries(this.#typed) });
    if (round !== this.#round) return; // something was typed since
    this.#problems.clear();
    if (!answer.ok) this.#say(answer.error);
    for (const { key, sentence } of answer.problems ?? []) {
      this.#problems.set(key, [...(this.#problems.get(key) ?? []), sentence]);
    }
    this.#show();
  }

  #show(state = "") {
    for (const row of this.box.querySelectorAll(".setting")) {
      const found = this.#problems.get(row.dataset.key) ?? [];
      if (found.length) row.closest("details").open = true;
      row.classList.toggle("is-changed", this.#typed.has(row.dataset.key));
      row.querySelector(".problem").textContent = found.map((one) => one.replace(`${row.dataset.key}: `, "")).join("; ");
      row.querySelector("input, select, output")?.setAttribute("aria-invalid", String(found.length > 0));
      if (found.length && row.contains(document.activeElement)) row.scrollIntoView({ block: "nearest" });
    }
    const rows = new Set([...this.box.querySelectorAll(".setting:not([hidden])")].map((row) => row.dataset.key));
    const others = [...this.#problems].filter(([key]) => !rows.has(key)).flatMap(([, found]) => found);
    if (others.length) this.#say(others.join("; "));
    const count = this.#typed.size;
    byId("settings-count").textContent = count ? `${count} changed` : "";
    let why = "";
    if (state === "checking") why = "being checked";
    else if (this.#problems.size) why = "something is wrong: see the fields in red";
    else if (count === 0) why = "nothing has changed";
    allow(byId("settings-save"), why);
    allow(byId("settings-undo"), this.#form?.earlier ? "" : "there is no earlier text of the page to go back to");
  }

  async #save() {
    await this.#change("/api/settings/save", { changes: Object.fromEntries(this.#typed), base: this.#form.base });
  }

  async #undo() {
    await this.#change("/api/settings/undo", {});
  }

  async #change(address, body) {
    const taken = await this.seat.takeIfFree();
    const answer = taken.ok ? await request(this.connection, address, { ...body, key: this.connection.key }) : taken;
    if (!answer.ok) {
      this.#say(answer.error);
      return;
    }
    this.#typed.clear();
    await this.#load();
    this.#say(`${answer.said}. The program begins again with it, and waits for orders.`);
  }

  #find() {
    const words = byId("settings-find").value.trim().toLowerCase();
    for (const box of this.box.querySelectorAll("details")) {
      const rows = [...box.querySelectorAll(".setting")];
      for (const row of rows) row.hidden = !row.dataset.words.includes(words);
      box.hidden = rows.every((row) => row.hidden);
      if (words && !box.hidden) box.open = true;
    }
  }

  #say(text) {
    byId("settings-said").textContent = text ? text[0].toUpperCase() + text.slice(1) : "";
  }
}

function byId(id) {
  return document.getElementById(id);
}

function make(tag, kind, text = "") {
  const one = document.createElement(tag);
  if (kind) one.className = kind;
  one.textContent = text.replaceAll("`", "");
  return one;
}

function shown(key) {
  return make("output", "", key.value || key.default || "–");
}

function field(key) {
  if (key.kind === "flag" || key.kind === "choice") return choice(key);
  const input = document.createElement("input");
  input.type = "text";
  input.inputMode = key.kind === "number" || key.kind === "whole" ? "decimal" : "text";
  input.spellcheck = false;
  input.autocomplete = "off";
  input.maxLength = 500;
  input.value = key.value;
  input.placeholder = key.default;
  return input;
}

function choice(key) {
  const select = document.createElement("select");
  const choices = key.kind === "flag" ? ["true", "false"] : key.choices;
  if (key.default !== "" || key.value === "") {
    select.append(new Option(key.default ? `${key.default} (as without the key)` : "–", ""));
  }
  for (const one of choices) select.append(new Option(one, one));
  select.value = key.value;
  return select;
}

/** The bounds of a number in words: " (above 0, at most 1000)". */
function limits(key) {
  const words = { above: "above", least: "at least", below: "below", most: "at most" };
  const limits = Object.entries(key.limits ?? {}).map(([name, value]) => `${words[name]} ${value}`);
  return limits.length ? ` (${limits.join(", ")})` : "";
}
