// Tables that can be sorted and copied, and one selection that tables, plan and 3D view share.
"use strict";
const report = JSON.parse(document.getElementById("report-data").textContent);

/** What is selected: the id of a dimension or of a face, or null; listeners hear every change. */
const selection = {
  id: null,
  listeners: [],
  /** Ids that light up for it: a dimension brings its two faces. */
  lit() {
    const dimension = report.dimensions.find((d) => d.id === this.id);
    return new Set(dimension ? [dimension.id, ...dimension.faces] : this.id === null ? [] : [this.id]);
  },
  /** Select, or put out what is selected already. */
  toggle(id) {
    this.id = this.id === id ? null : id;
    this.listeners.forEach((listener) => listener());
  },
};

function describe(id) {
  if (id === null) return "Nothing is selected.";
  const dimension = report.dimensions.find((d) => d.id === id);
  if (dimension) return `${id}: ${dimension.what}, ${dimension.text} m${dimension.inferred ? ", inferred" : ""}.`;
  const face = report.faces.find((f) => f.id === id);
  return face ? face.about : "";
}

const says = document.getElementById("says");
const picked = document.getElementById("picked");
selection.listeners.push(() => {
  const lit = selection.lit();
  says.textContent = describe(selection.id);
  // The same at the lower edge of the window, with ways to where it is lit.
  picked.hidden = selection.id === null;
  picked.firstElementChild.textContent = describe(selection.id);
  for (const element of document.querySelectorAll("[data-shows]")) {
    element.classList.toggle("lit", element.dataset.shows.split(" ").some((id) => lit.has(id)));
  }
  for (const row of document.querySelectorAll("tr[data-pick]")) {
    row.classList.toggle("lit", row.dataset.pick === selection.id);
    row.querySelector("button").setAttribute("aria-pressed", String(row.dataset.pick === selection.id));
  }
});

for (const row of document.querySelectorAll("tr[data-pick]")) {
  const cell = row.cells[0];
  const button = document.createElement("button");
  button.type = "button";
  button.className = "pick";
  button.setAttribute("aria-pressed", "false");
  button.setAttribute("aria-label", `Show ${cell.textContent} in the 3D view and the plan`);
  button.textContent = cell.textContent;
  cell.replaceChildren(button);
  row.addEventListener("click", () => {
    // Marking text for copying is not a click on the row.
    if (!String(getSelection())) selection.toggle(row.dataset.pick);
  });
}
for (const element of document.querySelectorAll("svg [data-shows]")) {
  element.addEventListener("click", () => selection.toggle(element.dataset.shows.split(" ")[0]));
}
picked.querySelector("button").addEventListener("click", () => selection.toggle(selection.id));
addEventListener("keydown", (event) => {
  if (event.key === "Escape" && selection.id !== null) selection.toggle(selection.id);
});

/** Sort by a column: numbers by size, ids as people count (wall-2 before wall-10); again: the other way. */
function sortBy(table, column, header) {
  const down = header.getAttribute("aria-sort") === "ascending";
  const key = (row) => row.cells[column].dataset.sort ?? row.cells[column].textContent;
  const rows = [...table.tBodies[0].rows];
  rows.sort((a, b) => {
    const [x, y] = [key(a), key(b)];
    // What is not known goes last, whichever way.
    if (x === "" || y === "") return (x === "") - (y === "");
    const difference = Number(x) - Number(y);
    const order = Number.isNaN(difference) ? x.localeCompare(y, "en", { numeric: true }) : difference;
    return down ? -order : order;
  });
  for (const other of header.parentNode.cells) other.removeAttribute("aria-sort");
  header.setAttribute("aria-sort", down ? "descending" : "ascending");
  table.tBodies[0].append(...rows);
}

/** The table as tab-separated lines, in the order in which it stands. */
function asText(table) {
  const cell = (c) => c.dataset.copy ?? c.textContent.trim();
  return [...table.rows].map((row) => [...row.cells].map(cell).join("\t")).join("\n") + "\n";
}

async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    // Pages opened as files may not use the clipboard in every browser; the old way still works.
    const area = document.createElement("textarea");
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
  return true;
}

for (const table of document.querySelectorAll("table.sortable")) {
  [...table.tHead.rows[0].cells].forEach((header, column) => {
    header.dataset.copy ??= header.textContent;
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = header.textContent;
    button.title = "Sort by this column";
    header.replaceChildren(button);
    button.addEventListener("click", () => sortBy(table, column, header));
  });
  const button = document.createElement("button");
  button.type = "button";
  button.className = "copy";
  button.textContent = "Copy table";
  const told = document.createElement("span");
  told.setAttribute("role", "status");
  told.className = "quiet";
  button.addEventListener("click", async () => {
    told.textContent = (await copy(asText(table))) ? " Copied; paste it into a spreadsheet." : " Not allowed here.";
  });
  const bar = document.createElement("p");
  bar.className = "tools";
  bar.append(button, told);
  table.parentNode.before(bar);
}
