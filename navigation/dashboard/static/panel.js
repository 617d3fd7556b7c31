// Boxes that a button opens and closes: layers, the legend, the list of keys. None is modal: STOP stays
// where it is, and works. One is open at a time.

export class Panel {
  static #all = [];

  /** Box NAME and button NAME-open; with a button NAME-close the focus goes there. */
  constructor(name) {
    this.box = document.getElementById(name);
    this.button = document.getElementById(`${name}-open`);
    this.cross = document.getElementById(`${name}-close`);
    this.button.addEventListener("click", () => this.toggle());
    this.cross?.addEventListener("click", () => this.close());
    Panel.#all.push(this);
  }

  /** The open one, if any. */
  static get open() {
    return Panel.#all.find((panel) => panel.isOpen);
  }

  get isOpen() {
    return !this.box.hidden;
  }

  toggle() {
    if (this.isOpen) {
      this.close();
      return;
    }
    Panel.open?.close();
    this.#show(true);
    this.cross?.focus();
  }

  close() {
    if (!this.isOpen) return;
    const hadFocus = this.box.contains(document.activeElement);
    this.#show(false);
    if (hadFocus) this.button.focus();
  }

  #show(on) {
    this.box.hidden = !on;
    this.button.setAttribute("aria-expanded", String(on));
  }
}
