// The script of the page: sorts tables and switches selectors off.
//
// It makes its own controls, so that a page without it shows everything and no control that does nothing. Rows, columns,
// legends and examples are found by the name of the selector that they begin with, artists of figures by their attribute
// data-selector (see figures.marked).
(() => {
  "use strict";
  const switches = JSON.parse(document.querySelector("main").dataset.switches);
  const names = Object.keys(switches);
  const parts = new Map();  // selector -> the elements of its switch
  for (const name of names) {
    const elements = [];
    for (const selector of [name, ...switches[name]]) parts.set(selector, elements);
  }
  const add = (selector, element) => { if (element && parts.has(selector)) parts.get(selector).push(element); };
  // The first text of an element itself: a name, without the remark in an element behind it.
  const nameOf = element => {
    const text = [...element.childNodes].find(node => node.nodeType === 3 && node.nodeValue.trim());
    return text ? text.nodeValue.trim() : "";
  };
  // The cell of a row in a column; null where a cell spans several columns.
  const cellAt = (row, column) => {
    for (const cell of row.cells) {
      if (column < cell.colSpan) return cell.colSpan === 1 ? cell : null;
      column -= cell.colSpan;
    }
    return null;
  };
  const make = (tag, properties, ...children) => {
    const element = Object.assign(document.createElement(tag), properties);
    element.append(...children);
    return element;
  };

  // --- selectors

  const find = () => {
    for (const artist of document.querySelectorAll("[data-selector]")) add(artist.dataset.selector, artist);
    for (const item of document.querySelectorAll(".legend li")) add(nameOf(item), item);
    for (const name of document.querySelectorAll(".cell figcaption b")) add(nameOf(name), name.closest(".cell"));
    for (const table of document.querySelectorAll("main table")) {
      for (const row of table.tBodies[0].rows) add(nameOf(row.cells[0]), row);
      [...table.tHead.rows[0].cells].forEach((head, column) => {
        if (parts.has(nameOf(head))) for (const row of table.rows) add(nameOf(head), cellAt(row, column));
      });
    }
  };
  const makeSwitches = () => {
    const summary = make("summary", {});
    const boxes = names.map(name => make("input", {
      type: "checkbox", checked: true, autocomplete: "off", value: name, onchange: () => show() }));
    const show = () => {
      for (const box of boxes) {
        for (const part of parts.get(box.value)) part.classList.toggle("off", !box.checked);
      }
      const count = boxes.filter(box => box.checked).length;
      summary.textContent = "Selectors shown: " + (count === names.length ? "all " : count + " of ") + names.length;
    };
    const set = checked => { for (const box of boxes) box.checked = checked; show(); };
    const list = make("div", { className: "boxes" },
      ...boxes.map(box => make("label", {}, box, box.value)),
      make("button", { type: "button", textContent: "all", onclick: () => set(true) }),
      make("button", { type: "button", textContent: "none", onclick: () => set(false) }),
      make("span", { className: "small", textContent: "Marks and sentences always compare all of them." }));
    const bar = make("details", { className: "switches", open: names.length <= 14 }, summary, list);
    show();
    document.querySelector("main").before(bar);
  };

  // --- tables

  const valueOf = cell => {
    if (!cell) return "";
    const copy = cell.cloneNode(true);
    for (const mark of copy.querySelectorAll(".mark")) mark.remove();
    for (const end of copy.querySelectorAll("br")) end.replaceWith(" ");
    const text = cell.dataset.value || copy.textContent.trim();
    return text === "\u2013" ? "" : text;
  };
  const numberOf = text => parseFloat(text.replace(/^[<>\u2264\u2265\u00d7] ?/, ""));
  const compare = (values, sign) => {
    const texts = values.filter(value => value !== "");
    const numeric = texts.every(text => !isNaN(numberOf(text)));
    return (a, b) => {
      const one = values[a], other = values[b];
      if (one === "" || other === "") return (one === "") - (other === "") || a - b;
      const order = numeric ? numberOf(one) - numberOf(other) : one.localeCompare(other, "en", { numeric: true });
      return sign * order || a - b;
    };
  };
  const sortable = table => {
    const body = table.tBodies[0], rows = [...body.rows], heads = [...table.tHead.rows[0].cells];
    // Rows that move as one: a row and the paper's numbers below it. Headings and sums do not move.
    const units = [], fixed = [];
    for (const row of rows) {
      if (row.classList.contains("heading")) continue;
      if (row.classList.contains("total")) fixed.push(row);
      else if (row.classList.contains("paper") && units.length) units[units.length - 1].push(row);
      else units.push([row]);
    }
    if (units.length < 2) return;
    const sort = (head, column) => {
      // The third click restores the order of the report.
      const next = { ascending: "descending", descending: "" };
      const before = head.getAttribute("aria-sort");
      const direction = before in next ? next[before] : "ascending";
      for (const other of heads) other.removeAttribute("aria-sort");
      for (const row of rows) row.classList.toggle("unused", direction !== "" && row.classList.contains("heading"));
      if (direction === "") return body.append(...rows);
      head.setAttribute("aria-sort", direction);
      const values = units.map(unit => valueOf(cellAt(unit[0], column)));
      const order = units.map((_, i) => i).sort(compare(values, direction === "ascending" ? 1 : -1));
      body.append(...rows.filter(row => row.classList.contains("heading")));
      body.append(...order.flatMap(i => units[i]), ...fixed);
    };
    heads.forEach((head, column) => {
      const button = make("button", { type: "button", title: "Sort", onclick: () => sort(head, column) });
      if (!head.textContent.trim()) button.setAttribute("aria-label", "Sort by name");
      button.append(...head.childNodes);
      head.append(button);
    });
    table.classList.add("sortable");
  };

  find();
  if (names.length > 1) makeSwitches();
  document.querySelectorAll("main table").forEach(sortable);
})();
