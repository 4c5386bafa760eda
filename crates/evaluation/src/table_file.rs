//! Rows in a Parquet file: written at once and atomically, read back as they were.
//!
//! Rows are sorted by their key and nothing in the file depends on time or machine, so equal rows give equal bytes.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use crate::row::Row;

/// Why a table could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The file system refuses.
    #[error("cannot {verb} {}: {source}; {advice}", path.display())]
    Io {
        /// What was tried.
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
        /// What to do next.
        advice: &'static str,
    },
    /// The file is no Parquet file, or a damaged one.
    #[error("{} is no readable Parquet file ({source}); name another file, or remove this one", path.display())]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What the reader says.
        source: ParquetError,
    },
    /// The file holds another table.
    #[error(
        "{} holds other columns than this program writes (first difference: {column}); it is another table or of \
         another version: name another file",
        path.display()
    )]
    OtherColumns {
        /// The file.
        path: PathBuf,
        /// The first column that differs.
        column: String,
    },
}

const UNREADABLE: &str = "check its path and rights";
const UNWRITABLE: &str = "choose a folder you may write to, or free space on it";

/// Writes `rows` to `path`, all or nothing: readers see the old file or the whole new one.
///
/// # Errors
/// [`TableError::Io`] and [`TableError::Parquet`].
pub fn write_table(path: &Path, rows: &[&Row]) -> Result<(), TableError> {
    let mut sorted = rows.to_vec();
    sorted.sort_by_cached_key(|row| row.key());
    let bytes =
        to_parquet(&sorted).map_err(|source| TableError::Parquet { path: path.to_owned(), source })?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".tmp");
    let temporary = path.with_file_name(name);
    let io = |source| TableError::Io { verb: "write", path: path.to_owned(), source, advice: UNWRITABLE };
    let mut file = File::create(&temporary).map_err(io)?;
    file.write_all(&bytes).and_then(|()| file.sync_all()).map_err(io)?;
    std::fs::rename(&temporary, path).map_err(io)
}

fn to_parquet(rows: &[&Row]) -> Result<Vec<u8>, ParquetError> {
    let schema = Type::group_type_builder("run").with_fields(Row::columns()?).build()?;
    let properties = WriterProperties::builder().set_created_by("cncbf evaluate".to_owned()).build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    Row::write_group(rows, &mut group)?;
    group.close()?;
    writer.into_inner()
}

/// Reads every row of `path`.
///
/// # Errors
/// [`TableError`] if it cannot be read or is no such table.
pub fn read_table(path: &Path) -> Result<Vec<Row>, TableError> {
    let file = File::open(path).map_err(|source| TableError::Io {
        verb: "read",
        path: path.to_owned(),
        source,
        advice: UNREADABLE,
    })?;
    let parquet = |source| TableError::Parquet { path: path.to_owned(), source };
    let reader = SerializedFileReader::new(file).map_err(parquet)?;
    let found: Vec<String> = {
        let schema = reader.metadata().file_metadata().schema();
        schema.get_fields().iter().map(|field| field.name().to_owned()).collect()
    };
    if found != Row::COLUMNS {
        let differs =
            |index: &usize| found.get(*index).map(String::as_str) != Row::COLUMNS.get(*index).copied();
        let index = (0..found.len().max(Row::COLUMNS.len())).find(differs).unwrap_or(0);
        let column = found.get(index).cloned().unwrap_or_else(|| Row::COLUMNS[index].to_owned());
        return Err(TableError::OtherColumns { path: path.to_owned(), column });
    }
    let rows = reader.get_row_iter(None).map_err(parquet)?;
    rows.map(|row| {
        Row::read(&row.map_err(parquet)?)
            .map_err(|column| TableError::OtherColumns { path: path.to_owned(), column: column.to_owned() })
    })
    .collect()
}
