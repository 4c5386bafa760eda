//! What the sources of `messages` say, free of Rust.

/// Everything that travels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Schema {
    /// Obstacles that one message can carry.
    pub max_obstacles: u64,
    /// Structures, each after those it contains.
    pub structs: Vec<Struct>,
    /// Enumerations that travel as `u32`.
    pub codes: Vec<Codes>,
    /// Sets of bits that travel as `u32`.
    pub flags: Vec<Codes>,
}

/// A structure, with or without a service of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Struct {
    /// Name in Rust.
    pub name: String,
    /// Its documentation, line by line.
    pub doc: Vec<String>,
    /// Versioned type name.
    pub type_name: String,
    /// Service name without the instance, where it travels by itself.
    pub service: Option<String>,
    /// Its fields in order.
    pub fields: Vec<Field>,
    /// Size, bytes.
    pub size: u64,
}

/// A field of a structure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Name in Rust.
    pub name: String,
    /// Its documentation, line by line.
    pub doc: Vec<String>,
    /// What it holds.
    pub field_type: FieldType,
    /// Where it begins, bytes from the beginning of the structure.
    pub offset: u64,
}

/// What a field can hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FieldType {
    /// `u32`.
    U32,
    /// `u64`.
    U64,
    /// `f64`.
    F64,
    /// Another structure, by name.
    Struct(String),
    /// So many of the same.
    Array(Box<FieldType>, u64),
}

/// An enumeration or a set of bits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Codes {
    /// Name in Rust.
    pub name: String,
    /// Its documentation, line by line.
    pub doc: Vec<String>,
    /// Its members.
    pub choices: Vec<Choice>,
}

/// A member of an enumeration or a set of bits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    /// Name in Rust.
    pub name: String,
    /// Its documentation, line by line.
    pub doc: Vec<String>,
    /// The number on the wire.
    pub code: u64,
    /// The name in logs and reports; empty for bits.
    pub label: String,
}
