// SPDX-License-Identifier: Apache-2.0

// Without this script the page says the same; with it tables are sorted by pressing their heads.
const value = (row, column) => {
  const cell = row.cells[column];
  if (!('v' in cell.dataset)) return cell.textContent;
  return cell.dataset.v === '' ? null : Number(cell.dataset.v);  // null: there is nothing to say
};
const order = (a, b) => typeof a === 'string' ? String(a).localeCompare(b, 'en', {numeric: true}) : a - b;
for (const table of document.querySelectorAll('table.sortable')) {
  table.classList.add('live');
  const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0];
  heads.forEach((head, column) => {
    head.tabIndex = 0;
    const sort = () => {
      // Numbers from the largest on at first: one looks for the worst.
      const first = body.rows[0];
      const down = head.ariaSort ? head.ariaSort === 'ascending'
        : first && typeof value(first, column) !== 'string';
      heads.forEach((other) => other.removeAttribute('aria-sort'));
      head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
      const rows = [...body.rows].map((row) => [value(row, column), row]);
      rows.sort((a, b) => (a[0] === null) - (b[0] === null) ||
        (down ? order(b[0], a[0]) : order(a[0], b[0])));
      body.append(...rows.map((pair) => pair[1]));
    };
    head.onclick = sort;
    head.onkeydown = (event) => { if (event.key === 'Enter') sort(); };
  });
}
const bakes = document.getElementById('bakes');
if (bakes && bakes.tBodies[0].rows.length > 1) {
  const find = document.getElementById('find'), state = document.getElementById('state');
  const shown = document.getElementById('shown'), rows = [...bakes.tBodies[0].rows];
  const filter = () => {
    const word = find.value.trim().toLowerCase();
    let count = 0;
    for (const row of rows) {
      const fits = row.cells[0].textContent.toLowerCase().includes(word) &&
        (!state.value || row.cells[1].textContent === state.value);
      row.hidden = !fits;
      count += fits;
    }
    shown.textContent = count === rows.length ? '' : count + ' of ' + rows.length;
  };
  find.oninput = state.onchange = filter;
  find.parentElement.hidden = false;
  filter();
}
