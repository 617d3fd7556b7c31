// The log, newest first.

const KEPT = 200;

export class Log {
  constructor(connection) {
    this.list = document.getElementById("log");
    this.filter = document.getElementById("log-filter");
    this.filter.value = localStorage.getItem("clearway.log") ?? "all";
    this.list.dataset.only = this.filter.value;
    this.filter.addEventListener("change", () => {
      localStorage.setItem("clearway.log", this.filter.value);
      this.list.dataset.only = this.filter.value;
    });
    connection.on("hello", () => this.list.replaceChildren());
    connection.on("log", (piece) => piece.items.forEach((line) => this.#add(line)));
  }

  #add([seconds, level, text]) {
    const item = document.createElement("li");
    item.dataset.level = level;
    const time = document.createElement("time");
    time.textContent = new Date(seconds * 1000).toLocaleTimeString([], { hour12: false });
    time.dateTime = new Date(seconds * 1000).toISOString();
    const words = document.createElement("span");
    words.textContent = text;
    item.append(time, words);
    this.list.prepend(item);
    while (this.list.children.length > KEPT) this.list.lastElementChild.remove();
  }
}
