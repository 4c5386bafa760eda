//! A struct as columns of a Parquet file: one declaration gives the struct, the schema, writing and reading.

use std::sync::Arc;

use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int32Type, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::writer::SerializedColumnWriter;
use parquet::record::Field;
use parquet::schema::types::{Type, TypePtr};

/// Something that fits into one field of a table.
pub(crate) trait Cell: Sized {
    const PHYSICAL: Physical;
    const CONVERTED: ConvertedType = ConvertedType::NONE;
    const REPETITION: Repetition = Repetition::REQUIRED;

    fn write<'a>(
        cells: impl Iterator<Item = &'a Self>,
        column: &mut SerializedColumnWriter<'_>,
    ) -> Result<()>
    where
        Self: 'a;

    /// The field's value, if it has this type.
    fn read(field: &Field) -> Option<Self>;

    fn column(name: &str) -> Result<TypePtr> {
        let column = Type::primitive_type_builder(name, Self::PHYSICAL)
            .with_converted_type(Self::CONVERTED)
            .with_repetition(Self::REPETITION)
            .build()?;
        Ok(Arc::new(column))
    }
}

impl Cell for String {
    const PHYSICAL: Physical = Physical::BYTE_ARRAY;
    const CONVERTED: ConvertedType = ConvertedType::UTF8;

    fn write<'a>(
        cells: impl Iterator<Item = &'a Self>,
        column: &mut SerializedColumnWriter<'_>,
    ) -> Result<()> {
        let values: Vec<ByteArray> = cells.map(|text| text.as_str().into()).collect();
        column.typed::<ByteArrayType>().write_batch(&values, None, None).map(drop)
    }

    fn read(field: &Field) -> Option<Self> {
        if let Field::Str(text) = field { Some(text.clone()) } else { None }
    }
}

impl Cell for bool {
    const PHYSICAL: Physical = Physical::BOOLEAN;

    fn write<'a>(
        cells: impl Iterator<Item = &'a Self>,
        column: &mut SerializedColumnWriter<'_>,
    ) -> Result<()> {
        let values: Vec<bool> = cells.copied().collect();
        column.typed::<BoolType>().write_batch(&values, None, None).map(drop)
    }

    fn read(field: &Field) -> Option<Self> {
        if let Field::Bool(value) = field { Some(*value) } else { None }
    }
}

impl Cell for u32 {
    const PHYSICAL: Physical = Physical::INT32;
    const CONVERTED: ConvertedType = ConvertedType::UINT_32;

    fn write<'a>(
        cells: impl Iterator<Item = &'a Self>,
        column: &mut SerializedColumnWriter<'_>,
    ) -> Result<()> {
        let values: Vec<i32> = cells.map(|value| value.cast_signed()).collect();
        column.typed::<Int32Type>().write_batch(&values, None, None).map(drop)
    }

    fn read(field: &Field) -> Option<Self> {
        if let Field::UInt(value) = field { Some(*value) } else { None }
    }
}

impl Cell for u64 {
    const PHYSICAL: Physical = Physical::INT64;
    const CONVERTED: ConvertedType = ConvertedType::UINT_64;

    fn write<'a>(
        cells: impl Iterator<Item = &'a Self>,
        column: &mut SerializedColumnWriter<'_>,
    ) -> Result<()> {
        let values: Vec<i64> = cells.map(|value| value.cast_signed()).collect();
        column.typed::<Int64Type>().write_batch(&values, None, None).map(drop)
    }

    fn read(field: &Field) -> Option<Self> {
        if let Field::ULong(value) = field { Some(*value) } else { None }
    }
}

impl Cell for f64 {
    const PHYSICAL: Physical = Physical::DOUBLE;

    fn write<'a>(
        cells: impl Iterator<Item = &'a Self>,
        column: &mut SerializedColumnWriter<'_>,
    ) -> Result<()> {
        let values: Vec<f64> = cells.copied().collect();
        column.typed::<DoubleType>().write_batch(&values, None, None).map(drop)
    }

    fn read(field: &Field) -> Option<Self> {
        if let Field::Double(value) = field { Some(*value) } else { None }
    }
}

impl Cell for Option<f64> {
    const PHYSICAL: Physical = Physical::DOUBLE;
    const REPETITION: Repetition = Repetition::OPTIONAL;

    fn write<'a>(
        cells: impl Iterator<Item = &'a Self>,
        column: &mut SerializedColumnWriter<'_>,
    ) -> Result<()> {
        let cells: Vec<Self> = cells.copied().collect();
        let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
        let values: Vec<f64> = cells.into_iter().flatten().collect();
        column.typed::<DoubleType>().write_batch(&values, Some(&levels), None).map(drop)
    }

    fn read(field: &Field) -> Option<Self> {
        match field {
            Field::Null => Some(None),
            field => f64::read(field).map(Some),
        }
    }
}

pub(crate) fn ended_early() -> ParquetError {
    ParquetError::General("the row group has too few columns".to_owned())
}

/// Declares a struct whose fields are columns, named as the fields are and in their order.
macro_rules! table_row {
    (
        $(#[$meta:meta])*
        pub struct $name:ident {
            $($(#[$field_meta:meta])* pub $field:ident: $type:ty,)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
        pub struct $name {
            $($(#[$field_meta])* pub $field: $type,)*
        }

        impl $name {
            /// Names of the columns, in order.
            pub const COLUMNS: &[&str] = &[$(stringify!($field)),*];

            /// The columns with their types.
            pub(crate) fn columns() -> parquet::errors::Result<Vec<parquet::schema::types::TypePtr>> {
                Ok(vec![$(<$type as $crate::columns::Cell>::column(stringify!($field))?),*])
            }

            /// Writes all `rows` as one row group.
            pub(crate) fn write_group<W: std::io::Write + Send>(
                rows: &[&Self],
                group: &mut parquet::file::writer::SerializedRowGroupWriter<'_, W>,
            ) -> parquet::errors::Result<()> {
                $(
                    let mut column = group.next_column()?.ok_or_else($crate::columns::ended_early)?;
                    <$type as $crate::columns::Cell>::write(rows.iter().map(|row| &row.$field), &mut column)?;
                    column.close()?;
                )*
                Ok(())
            }

            /// Reads one row; the name of the first column that holds something else, if one does.
            pub(crate) fn read(row: &parquet::record::Row) -> Result<Self, &'static str> {
                let mut columns = row.get_column_iter();
                $(
                    let $field = columns
                        .next()
                        .and_then(|(_, field)| <$type as $crate::columns::Cell>::read(field))
                        .ok_or(stringify!($field))?;
                )*
                Ok(Self { $($field),* })
            }
        }
    };
}
pub(crate) use table_row;
