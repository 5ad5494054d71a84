//! Tables of numbers as text: a line with column names, and rows of numbers.

use std::borrow::Cow;
use std::cell::Cell;
use std::io::{self, BufRead, BufReader, Read, Take};
use std::path::Path;
use std::rc::Rc;

use ilon_files::{FileAccess, ReadError};

use super::{cell, is_head_of_log, quoted};
use crate::Error;
use crate::scenario::{SIZES, nearest};

/// The most rows of a table, or messages of a bag, that are read. Chosen.
pub const MOST_ROWS: usize = 20_000_000;

/// The longest row that is held in memory, in bytes: that of a quote without an end may be the
/// whole file. Chosen.
const MOST_ROW_BYTES: usize = 16 << 20;

/// The format of a table.
#[derive(Clone, Copy, Debug)]
pub struct TableFormat<'a> {
    /// The delimiter between columns.
    pub delimiter: u8,
    /// The line with the column names, counted from 1; 0 if there is none. Rows begin after it.
    pub header_line: usize,
    /// Whether decimals may have a comma.
    pub decimal_comma: bool,
    /// The largest number in SI units.
    pub largest: f64,
    /// The section of this format, for help texts. Without one, a line that begins with `#` is a
    /// comment, and every line has as many values as there are names.
    pub section: Option<&'a str>,
}

impl Default for TableFormat<'_> {
    fn default() -> Self {
        Self {
            delimiter: b',',
            header_line: 1,
            decimal_comma: false,
            largest: *SIZES.end(),
            section: None,
        }
    }
}

/// A source that ends with an error within a row that is too long.
struct RowByRow<R> {
    source: R,
    left: Rc<Cell<usize>>,
}

impl<R: Read> Read for RowByRow<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let most = bytes.len().min(self.left.get());
        if most == 0 && !bytes.is_empty() {
            let megabytes = MOST_ROW_BYTES >> 20;
            let words = format!("a row is longer than {megabytes} MB, or a quote has no end");
            return Err(io::Error::other(words));
        }
        let read = self.source.read(&mut bytes[..most])?;
        self.left.set(self.left.get() - read);
        Ok(read)
    }
}

/// A column that is read.
#[derive(Clone, Debug)]
pub struct Column {
    place: usize,
    name: String,
    /// The factor to SI units.
    pub factor: f64,
}

/// The bytes of a file, up to its largest size.
type Bytes = BufReader<Take<Box<dyn Read>>>;

/// A table that is read row by row; values are those of the current row.
pub struct Table<'a> {
    path: &'a Path,
    format: TableFormat<'a>,
    names: Vec<String>,
    /// Whether numbers follow the names: nothing is shown of other files.
    is_log: bool,
    reader: ::csv::Reader<RowByRow<Bytes>>,
    /// Bytes that may still be read for the row.
    left: Rc<Cell<usize>>,
    record: ::csv::ByteRecord,
    /// The result of reading ahead the row in `record`.
    ahead: Option<Result<bool, ::csv::Error>>,
    rows: usize,
}

impl<'a> Table<'a> {
    /// Opens a table of at most `most_bytes`, and reads its column names.
    ///
    /// # Errors
    /// [`Error::Read`] if the file cannot be read, [`Error::Contents`] if it is too large or has
    /// another delimiter.
    pub fn open(
        path: &'a Path,
        files: &FileAccess,
        most_bytes: u64,
        format: TableFormat<'a>,
    ) -> Result<Self, Error> {
        let unreadable = |fault: ReadError| match fault {
            ReadError::TooLarge(_) => Error::contents(path, fault.to_string(), "cut it into parts"),
            fault => Error::read(path, &fault),
        };
        let file = files.reader(path, most_bytes).map_err(unreadable)?;
        let mut lines = BufReader::new(file.take(most_bytes));
        for _ in 1..format.header_line {
            let skipped = lines.skip_until(b'\n');
            if skipped.map_err(|fault| unreadable(fault.into()))? == 0 {
                break;
            }
        }
        let is_stated = format.section.is_some();
        let left = Rc::new(Cell::new(0));
        let source = RowByRow {
            source: lines,
            left: Rc::clone(&left),
        };
        let mut table = Self {
            path,
            format,
            names: Vec::new(),
            is_log: false,
            reader: ::csv::ReaderBuilder::new()
                .has_headers(false)
                .delimiter(format.delimiter)
                .trim(::csv::Trim::All)
                .flexible(is_stated)
                .comment((!is_stated).then_some(b'#'))
                .from_reader(source),
            left,
            record: ::csv::ByteRecord::new(),
            ahead: None,
            rows: 0,
        };
        if format.header_line > 0 {
            if !table.advance()? {
                return Err(table.fault(
                    format!(
                        "it ends before line {}, which should name its columns",
                        format.header_line
                    ),
                    match format.section {
                        Some(section) => format!("see `{section}.header_line`"),
                        None => "begin it with a line of names".to_owned(),
                    },
                ));
            }
            table.names = texts(&table.record).map(Cow::into_owned).collect();
            table.refuse_another_delimiter()?;
        }
        let first = table.read_record();
        table.is_log =
            matches!(first, Ok(true)) && is_head_of_log(&table.names, texts(&table.record));
        table.ahead = Some(first);
        Ok(table)
    }

    /// The names of its columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The column with this name, if there is one; `factor` converts to SI units.
    ///
    /// # Errors
    /// [`Error::Contents`] if several have it.
    pub fn find(&self, name: &str, factor: f64) -> Result<Option<Column>, Error> {
        let mut places = (0..self.names.len()).filter(|place| self.names[*place] == name);
        let Some(place) = places.next() else {
            return Ok(None);
        };
        if places.next().is_none() {
            let mut column = self.column_at(place, factor);
            name.clone_into(&mut column.name);
            return Ok(Some(column));
        }
        Err(self.fault(
            format!("the column `{}` stands twice", quoted(name)),
            match self.format.section {
                Some(_) => "give the index of the right one, counted from 1",
                None => "keep the one that is meant",
            },
        ))
    }

    /// The column at an index from 0. It is named by its number: of a file that is not a log, only
    /// names given by the user are shown.
    pub fn column_at(&self, place: usize, factor: f64) -> Column {
        Column {
            place,
            name: (place + 1).to_string(),
            factor,
        }
    }

    /// The error for a missing column; `key` is the one that names it.
    pub fn missing(&self, name: &str, key: &str) -> Error {
        let names = || self.names.iter().map(String::as_str);
        let near = nearest(name, names()).filter(|_| self.is_log);
        let help = match (near, self.format.section) {
            (Some(near), _) => format!(
                "did you mean `{0}`? Then write `{key} = \"{0}\"`",
                quoted(near)
            ),
            (None, _) if self.is_log => {
                let listed: Vec<String> = names().take(20).map(quoted).collect();
                format!("name it by `{key}`; its columns are {}", listed.join(", "))
            }
            (None, None) => format!("name it by `{key}`"),
            (None, Some(section)) => format!(
                "nothing of it is shown, since no row of numbers follows line {}: see `{section}.header_line` and `{section}.delimiter`",
                self.format.header_line
            ),
        };
        self.fault(format!("the column `{}` is missing", quoted(name)), help)
    }

    /// Advances to the next row; `false` at the end.
    ///
    /// # Errors
    /// [`Error::Contents`] for a line that is not a row, and for more than [`MOST_ROWS`].
    pub fn next_row(&mut self) -> Result<bool, Error> {
        let is_row = self.advance()?;
        self.rows += usize::from(is_row);
        if self.rows > MOST_ROWS {
            let message = format!("it has more than {MOST_ROWS} rows");
            return Err(self.fault(message, "cut it into parts"));
        }
        Ok(is_row)
    }

    /// A fault of the file, and how to repair it.
    pub fn fault(&self, message: impl Into<String>, help: impl Into<String>) -> Error {
        Error::contents(self.path, message, help)
    }

    fn read_record(&mut self) -> Result<bool, ::csv::Error> {
        self.left.set(MOST_ROW_BYTES);
        self.reader.read_byte_record(&mut self.record)
    }

    /// Reads a line; `false` at the end.
    fn advance(&mut self) -> Result<bool, Error> {
        let read = match self.ahead.take() {
            Some(read) => read,
            None => self.read_record(),
        };
        read.map_err(|error| {
            self.fault(
                error.to_string(),
                "give every line as many values as the header has names, as plain text",
            )
        })
    }

    /// Refuses a file with another delimiter: it has a single column, named by the whole line.
    fn refuse_another_delimiter(&self) -> Result<(), Error> {
        let [only] = self.names.as_slice() else {
            return Ok(());
        };
        let Some(found) = only.chars().find(|letter| ",;\t|".contains(*letter)) else {
            return Ok(());
        };
        Err(self.fault(
            format!(
                "line {}: its columns are separated by {found:?}",
                self.format.header_line
            ),
            match (self.format.section, found) {
                (Some(section), '\t') => format!("write `{section}.delimiter = \"tab\"`"),
                (Some(section), _) => format!("write `{section}.delimiter = \"{found}\"`"),
                (None, _) => {
                    "separate them by commas, and write numbers with decimal points".to_owned()
                }
            },
        ))
    }

    /// The text of a column in the row.
    ///
    /// # Errors
    /// [`Error::Contents`] if the row is too short.
    pub fn text(&self, column: &Column) -> Result<Cow<'_, str>, Error> {
        let cell = self.record.get(column.place).map(String::from_utf8_lossy);
        cell.ok_or_else(|| {
            self.fault(
                format!(
                    "line {} has {} columns, and no column {}",
                    self.line(),
                    self.record.len(),
                    column.place + 1
                ),
                "the row is cut off, or its columns have another separator",
            )
        })
    }

    /// The number of a column in the row, in SI units; `None` for an empty cell or a marker of a
    /// missing value.
    ///
    /// # Errors
    /// [`Error::Contents`] for any other content.
    pub fn number(&self, column: &Column) -> Result<Option<f64>, Error> {
        let text = self.text(column)?;
        let is = |word: &str| text.eq_ignore_ascii_case(word);
        if ["", "nan", "na", "null", "none"].into_iter().any(is) {
            return Ok(None);
        }
        let number = match self.format.decimal_comma && !text.contains('.') {
            true => text.replacen(',', ".", 1).parse::<f64>(),
            false => text.parse::<f64>(),
        };
        match number.map(|number| number * column.factor) {
            Ok(number) if number.abs() <= self.format.largest => Ok(Some(number)),
            Ok(number) if number.is_finite() => Err(self.beyond(column)),
            _ => {
                let help = match self.format.section {
                    Some(section) if text.contains(',') => format!(
                        "numbers have decimal commas here: write `{section}.decimal_comma = true`"
                    ),
                    Some(section) if self.line() <= 10 => {
                        format!("rows begin after `{section}.header_line`: is the header longer?")
                    }
                    _ => "write a number with a decimal point, or leave the line out".to_owned(),
                };
                Err(self.wrong(column, "a number", help))
            }
        }
    }

    /// The number of a column in the row that must not be empty, in SI units.
    ///
    /// # Errors
    /// [`Error::Contents`] without one.
    pub fn needed(&self, column: &Column) -> Result<f64, Error> {
        self.number(column)?.ok_or_else(|| {
            self.fault(
                format!(
                    "line {}: `{}` holds no number",
                    self.line(),
                    quoted(&column.name)
                ),
                "fill it in, or leave the line out",
            )
        })
    }

    /// The fault of a cell with a wrong content.
    pub fn wrong(&self, column: &Column, must: &str, help: impl Into<String>) -> Error {
        let found = self.text(column).unwrap_or_default();
        self.fault(
            format!(
                "line {}: `{}` is {}, but must be {must}",
                self.line(),
                quoted(&column.name),
                cell(&found)
            ),
            help,
        )
    }

    /// The fault of a number that is too large or too small.
    pub fn beyond(&self, column: &Column) -> Error {
        let (least, most) = (SIZES.start(), self.format.largest);
        let must = format!("0 or of a size between {least:e} and {most:e}");
        self.wrong(column, &must, "write a finite number of usual size")
    }

    /// The line number at which the row begins.
    fn line(&self) -> usize {
        let line = self.record.position().map_or(0, ::csv::Position::line);
        self.format.header_line.saturating_sub(1) + line as usize
    }
}

/// The cells of a line as text.
fn texts(record: &::csv::ByteRecord) -> impl Iterator<Item = Cow<'_, str>> {
    record.iter().map(String::from_utf8_lossy)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row, or a name in quotes, that fills 17 MB is refused after 16; one of 15 MB is read.
    #[test]
    fn a_row_without_an_end_is_refused() {
        let of = |text: String| {
            let path = Path::new("log.csv");
            let files = FileAccess::of_memory([(path.into(), text.into_bytes())]);
            let table = Table::open(path, &files, 1 << 30, TableFormat::default());
            table.and_then(|mut table| {
                while table.next_row()? {}
                Ok(table.rows)
            })
        };
        let wide = |megabytes: usize| "0".repeat(megabytes << 20);
        let refused = [
            wide(17),
            format!("t_s,x_m\n\"{}", wide(17)),
            format!("t_s,x_m\n0,1\n0,1\n{},1\n", wide(17)),
        ];
        for text in refused {
            let error = of(text).expect_err("it is too long").to_string();
            assert!(error.contains("a row is longer than 16 MB"), "{error}");
        }
        // Short rows may be many megabytes in all.
        assert_eq!(
            of(format!("t_s,x_m\n{}", "0,1\n".repeat(5 << 20))).ok(),
            Some(5 << 20)
        );
        assert_eq!(of(format!("t_s,x_m\n{},1\n", wide(15))).ok(), Some(1));
    }

    /// The first column has the index 0, and is called 1 as in a format.
    #[test]
    fn a_column_without_a_name_is_called_by_its_number_counted_from_one() {
        let path = Path::new("log.csv");
        let files = FileAccess::of_memory([(path.into(), b"0,1.5\n0.1,wide\n".to_vec())]);
        let format = TableFormat {
            header_line: 0,
            section: Some("log"),
            ..TableFormat::default()
        };
        let mut table = Table::open(path, &files, 100, format).expect("a table");
        let second = table.column_at(1, 2.0);
        assert!(table.next_row().expect("a row"));
        assert_eq!(table.number(&second).expect("a number"), Some(3.0));
        assert!(table.next_row().expect("another row"));
        let error = table.number(&second).expect_err("it is text").to_string();
        assert!(error.contains("line 2: `2` is text"), "{error}");
    }
}
