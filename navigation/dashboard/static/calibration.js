// A live calibration: the board's numbers, the picture with what is still needed, and what came of it.
// In the dashboard it is a panel, which is not modal: STOP stays where it is, and works.

import { drawBoardView } from "./board.js";
import { fill } from "./list.js";
import { allow, onPress } from "./press.js";
import { request } from "./request.js";

const ADDRESS = "/api/calibration";
const ASK_EVERY_MS = 150;
const ASK_AGAIN_MS = 2000;
const byId = (id) => document.getElementById(id);
const upper = (text) => text.slice(0, 1).toUpperCase() + text.slice(1);
const FIELDS = ["kind", "squares", "square_mm", "marker_mm", "dictionary"];

function say(place, text) {
  if (place.textContent !== text) place.textContent = text;
}

export class Calibration {
  #timer = 0;
  #frame = null;
  #answered = "";

  /** Without a seat it is always open, and only looks. */
  constructor(connection, seat) {
    Object.assign(this, { connection, seat });
    this.box = byId("calibration");
    if (seat) this.#makePanel();
    else {
      this.box.hidden = false;
      this.#ask();
    }
  }

  #makePanel() {
    this.open = byId("calibration-open");
    this.open.addEventListener("click", () => this.toggle());
    byId("calibration-close").addEventListener("click", () => this.close());
    for (const name of FIELDS) {
      const kept = localStorage.getItem(`clearway.board.${name}`);
      if (kept !== null) byId(`board-${name}`).value = kept;
    }
    byId("board-kind").addEventListener("change", () => this.#showKind());
    this.#showKind();
    onPress(byId("calibration-start"), (text) => this.#say(text), () => this.#start());
    onPress(byId("calibration-save"), (text) => this.#say(text), () => this.#order("save"));
    onPress(byId("calibration-cancel"), (text) => this.#say(text), () => this.#order("cancel"));
    this.connection.on("hello", () => { this.open.hidden = !this.seat.mayDrive; });
  }

  get isOpen() {
    return !this.box.hidden;
  }

  toggle() {
    this.box.hidden = !this.box.hidden;
    this.open.setAttribute("aria-expanded", String(this.isOpen));
    clearTimeout(this.#timer);
    if (this.isOpen) {
      byId("calibration-close").focus();
      this.#answered = "";
      this.#ask();
    } else {
      this.open.focus();
    }
  }

  close() {
    if (this.isOpen) this.toggle();
  }

  async #ask() {
    clearTimeout(this.#timer);
    const facts = await request(this.connection, ADDRESS);
    if (!this.isOpen) return;
    if (facts.ok) await this.#show(facts);
    else this.#refuse(facts.error);
    clearTimeout(this.#timer);
    if (facts.phase !== "ended") this.#timer = setTimeout(() => this.#ask(), facts.ok ? ASK_EVERY_MS : ASK_AGAIN_MS);
  }

  #refuse(error) {
    const pill = byId("calibration-phase");
    pill.hidden ||= pill.textContent !== "enough views";
    if (!this.seat) return this.#say("the program has ended, or is not reached");
    for (const name of ["board", "view", "save", "cancel"]) byId(`calibration-${name}`).hidden = true;
    this.#say(error);
  }

  async #show(facts) {
    const isIdle = facts.phase === "idle";
    const isShown = !isIdle && facts.state !== null;
    byId("calibration-board").hidden = !isIdle || facts.refusal !== "";
    byId("calibration-view").hidden = byId("calibration-phase").hidden = !isShown;
    byId("calibration-cancel").hidden = isIdle;
    byId("calibration-save").hidden = facts.phase !== "found";
    allow(byId("calibration-save"), "");
    const fitting = facts.phase === "fitting" ? "enough views: the lens is being fitted" : "";
    const sentence = facts.phase === "taking" ? facts.state?.sentence ?? "waiting for a picture" : "";
    this.#say(facts.refusal || this.#answered || fitting || facts.said || sentence);
    if (isShown && facts.state.frame !== this.#frame) await this.#draw(facts);
    if (isShown) this.#showPhase(facts);
  }

  async #draw({ state, remarks }) {
    this.#frame = state.frame;
    const answer = await fetch(`${ADDRESS}/picture.jpg?frame=${state.frame}`, { headers: { ...this.connection.authorization } }).catch(() => null);
    if (!answer?.ok) return;
    const picture = byId("calibration-picture");
    const before = picture.src;
    picture.src = URL.createObjectURL(await answer.blob());
    await picture.decode().catch(() => undefined);
    if (before) URL.revokeObjectURL(before);
    drawBoardView(byId("calibration-frame"), byId("calibration-overlay"), state);
    for (const place of this.box.querySelectorAll("[data-fact]")) say(place, upper(String(state[place.dataset.fact])));
    byId("calibration-still").value = state.still;
    byId("calibration-reached").value = state.worst_px === null ? 0 : Math.min(1, state.limit_px / state.worst_px);
    fill(byId("calibration-remarks"), remarks, () => remarks.toReversed().map((text) => Object.assign(document.createElement("li"), { textContent: upper(text) })));
  }

  #showPhase({ phase, state }) {
    const pill = byId("calibration-phase");
    const still = state.still > 0 ? ["hold still", "good"] : ["board seen", ""];
    const seen = state.outline ? still : ["no board seen", "warn"];
    const [text, kind] = phase === "ended" ? ["ended", "good"] : state.done ? ["enough views", "good"] : seen;
    pill.dataset.state = kind;
    say(pill, text);
  }

  async #start() {
    const board = Object.fromEntries(FIELDS.map((name) => [name, byId(`board-${name}`).value]));
    for (const name of FIELDS) localStorage.setItem(`clearway.board.${name}`, board[name]);
    await this.#order("start", board);
  }

  async #order(what, body = {}) {
    const taken = what === "cancel" ? { ok: true } : await this.seat.takeIfFree();
    const answer = taken.ok ? await request(this.connection, `${ADDRESS}/${what}`, { ...body, key: this.connection.key }) : taken;
    this.#answered = answer.ok ? "" : answer.error;
    await this.#ask();
  }

  #showKind() {
    const isChessboard = byId("board-kind").value === "chessboard";
    for (const one of this.box.querySelectorAll(".of-charuco")) one.hidden = isChessboard;
  }

  #say(text) {
    say(byId("calibration-said"), text ? upper(text) + (/[.!?]$/.test(text) ? "" : ".") : "");
  }
}
