// The list of keys. It is not modal: STOP stays where it is, and works.

export class Keys {
  constructor() {
    this.box = document.getElementById("keys");
    this.button = document.getElementById("keys-open");
    this.button.addEventListener("click", () => this.toggle());
    document.getElementById("keys-close").addEventListener("click", () => this.close());
  }

  get isOpen() {
    return !this.box.hidden;
  }

  toggle() {
    this.box.hidden = !this.box.hidden;
    this.button.setAttribute("aria-expanded", String(this.isOpen));
    if (this.isOpen) document.getElementById("keys-close").focus();
    else this.button.focus();
  }

  close() {
    if (this.isOpen) this.toggle();
  }
}
