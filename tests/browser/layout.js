() => {
  // Faults of the layout as it is now: what is cut, covered or half empty. Pixels of the screen.
  //
  // - cut: a text that leaves the page's width, or a box around it that hides what is outside; one
  //   that has to be scrolled to, but in lists that grow without a limit. A robot's line in the list
  //   may end in dots: the state says it whole when the robot is chosen.
  // - overlap: two cards, or two texts of a card, that share more than SLACK in both directions.
  // - half empty: a card of whose height texts and controls, with gaps up to GAP between and around
  //   them, cover less than FILLED. The state is left out: its height is fixed.
  const [SLACK, GAP, FILLED] = [3, 20, 0.6];
  const SHORTENED = ".robot-says";
  const LISTS = "#log, .places-box, .settings-scroll, .history-list";
  const faults = [];
  const isShown = (element) => element.checkVisibility({ visibilityProperty: true }) && !element.closest(".visually-hidden, .skip") && getComputedStyle(element).clipPath === "none";
  const name = (element) => element.id || element.className || element.tagName;
  const sameArea = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > SLACK && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > SLACK;

  const texts = [];
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const node = walker.currentNode;
    const element = node.parentElement;
    if (!node.textContent.trim() || element.closest(`script, svg, option, ${SHORTENED}`) || !isShown(element)) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    texts.push({ element, words: node.textContent.trim().slice(0, 30), boxes: [...range.getClientRects()] });
  }
  for (const { element, words, boxes } of texts) {
    const isCut = (outer) => boxes.some((box) => box.left < outer.left - 1 || box.right > outer.right + 1 || box.top < outer.top - SLACK || box.bottom > outer.bottom + SLACK);
    if (boxes.some((box) => box.left < -1 || box.right > document.documentElement.clientWidth + 1)) faults.push(`cut by the page: ${words}`);
    for (let outer = element; outer !== document.body; outer = outer.parentElement) {
      if (getComputedStyle(outer).overflow !== "visible" && !outer.matches(LISTS) && isCut(outer.getBoundingClientRect())) faults.push(`cut by ${name(outer)}: ${words}`);
      if (outer.matches(LISTS)) break;
    }
  }
  const pen = document.createElement("canvas").getContext("2d");
  for (const input of document.querySelectorAll("input[placeholder]")) {
    const style = getComputedStyle(input);
    pen.font = style.font;
    const room = input.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
    if (isShown(input) && pen.measureText(input.placeholder).width > room) faults.push(`cut by its field: ${input.placeholder}`);
  }

  const cards = [...document.querySelectorAll(".arena, .card")].filter((card) => isShown(card) && !card.parentElement.closest(".card"));
  const pairs = (all, report) => all.forEach((one, n) => all.slice(n + 1).forEach((other) => report(one, other)));
  pairs(cards, (one, other) => {
    if (sameArea(one.getBoundingClientRect(), other.getBoundingClientRect())) faults.push(`${name(one)} and ${name(other)} overlap`);
  });
  for (const card of [...cards, document.querySelector("header")]) {
    const inside = texts.filter(({ element }) => card.contains(element) && !element.closest(LISTS));
    pairs(inside, (one, other) => {
      if (one.boxes.some((a) => other.boxes.some((b) => sameArea(a, b)))) faults.push(`in ${name(card)} two texts overlap: ${one.words} / ${other.words}`);
    });
  }

  for (const card of cards.filter((one) => one.matches(".card:not(.now)"))) {
    const box = card.getBoundingClientRect();
    const parts = [
      ...texts.filter(({ element }) => card.contains(element)).flatMap(({ boxes }) => boxes),
      ...[...card.querySelectorAll("button, input, select, svg")].filter(isShown).map((one) => one.getBoundingClientRect()),
    ].filter(({ top, bottom }) => bottom > box.top && top < box.bottom).sort((a, b) => a.top - b.top);
    let [end, covered] = [box.top, 0];
    for (const { top, bottom } of [...parts, { top: box.bottom, bottom: box.bottom }]) {
      if (bottom < end) continue;
      covered += bottom - (top - end <= GAP ? end : top);
      end = bottom;
    }
    if (covered < FILLED * box.height) faults.push(`half empty, ${Math.round((100 * covered) / box.height)} % covered: ${name(card)}`);
  }
  return faults;
}
