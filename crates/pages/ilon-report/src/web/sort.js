// Tables whose columns sort: a click on a heading puts the least first, another click the largest. Cells without a value stay last.
document.querySelectorAll('table.sortable').forEach((table) => {
  const text = (row, column) => row.cells[column].textContent.trim();
  Array.from(table.tHead.rows[0].cells).forEach((head, column) => {
    if (!head.textContent) return;
    const button = document.createElement('button');
    button.type = 'button';
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener('click', () => {
      const way = head.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
      for (const other of table.tHead.rows[0].cells) other.removeAttribute('aria-sort');
      head.setAttribute('aria-sort', way > 0 ? 'ascending' : 'descending');
      const rows = Array.from(table.tBodies[0].rows);
      const isNone = (x) => x === '' || x === '\u2014';
      // Decided for the whole column, so that the order is one of numbers or one of texts.
      const isNumeric = rows.every((row) => isNone(text(row, column)) || !Number.isNaN(parseFloat(text(row, column))));
      rows.sort((p, q) => {
        const [a, b] = [text(p, column), text(q, column)];
        if (isNone(a) || isNone(b)) return isNone(a) - isNone(b);
        return way * (isNumeric ? parseFloat(a) - parseFloat(b) : a.localeCompare(b, undefined, { numeric: true }));
      });
      table.tBodies[0].append(...rows);
    });
  });
});
