// SPDX-License-Identifier: Apache-2.0
// Run at the end of the page over many bakes: presses each head of each table, and filters; its
// title is what it saw.
(() => {
const seen = [];
const expect = (what, right) => seen.push((right ? 'right' : 'wrong') + ': ' + what);
const read = (table, column) => [...table.tBodies[0].rows].map((row) => {
  const cell = row.cells[column];
  return cell.dataset.v === undefined ? cell.textContent : cell.dataset.v === '' ? null
    : Number(cell.dataset.v);
});
const isInOrder = (values) => values.filter((value) => value !== null).every((value, i, all) =>
  i === 0 || (typeof value === 'string'
    ? all[i - 1].localeCompare(value, 'en', {numeric: true}) <= 0 : all[i - 1] <= value));
for (const table of document.querySelectorAll('table')) {
  const rows = table.tBodies[0].rows.length;
  let sorted = true;
  [...table.tHead.rows[0].cells].forEach((head, column) => {
    for (let press = 0; press < 2; ++press) {
      head.click();
      const values = read(table, column), told = head.getAttribute('aria-sort');
      const gap = values.indexOf(null);
      sorted = sorted && isInOrder(told === 'ascending' ? values : values.reverse()) &&
        values.length === rows &&
        (gap < 0 || told !== 'ascending' || values.slice(gap).every((value) => value === null));
    }
  });
  expect(table.tHead.textContent + ' sorts ' + rows + ' rows', sorted);
}
const bakes = document.getElementById('bakes'), word = document.getElementById('find');
const left = () => [...bakes.tBodies[0].rows].filter((row) => !row.hidden).length;
const all = left();
word.value = bakes.tBodies[0].rows[0].cells[0].textContent;
word.oninput();
expect('a name leaves ' + left() + ' of ' + all, left() >= 1 && left() < all);
const root = document.documentElement;
expect('nothing is wider than the window', root.scrollWidth <= root.clientWidth);
document.title = seen.join('; ');
})();
