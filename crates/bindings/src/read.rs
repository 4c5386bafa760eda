//! The sources of `messages`, read with `syn`.

mod macros;

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use syn::{Attribute, Expr, ExprLit, ImplItem, Item, Lit, Meta, Type};

use self::macros::{Assertion, WireCodes, number};
use crate::{Choice, Codes, Field, FieldType, Schema, Struct, layout};

/// Why there is nothing to generate from.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// A source file is missing.
    #[error("cannot read {path}: {source}; is this the root of the repository?")]
    File {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A source file is not the Rust that was expected.
    #[error("{path}: {source}; teach the generator what changed in `messages`")]
    Syntax {
        /// Which file.
        path: PathBuf,
        /// What is wrong.
        source: syn::Error,
    },
    /// A structure cannot be written down in another language.
    #[error("`{name}` {what}")]
    Unfit {
        /// Which structure.
        name: String,
        /// What is wrong and what to do.
        what: String,
    },
}

/// What the files say, before they are put together.
#[derive(Default)]
struct Found {
    consts: BTreeMap<String, u64>,
    structs: Vec<syn::ItemStruct>,
    assertions: BTreeMap<String, Assertion>,
    services: BTreeMap<String, String>,
    codes: Vec<Codes>,
    bits: BTreeMap<String, Vec<Choice>>,
}

/// Reads the folder `crates/messages/src`.
///
/// # Errors
/// As [`ReadError`] tells.
pub fn schema(messages_src: &Path) -> Result<Schema, ReadError> {
    let root = parse(&messages_src.join("lib.rs"))?;
    let mut found = Found::default();
    found.take(&messages_src.join("lib.rs"), &root)?;
    for item in &root.items {
        if let Item::Mod(module) = item
            && module.content.is_none()
        {
            let path = messages_src.join(format!("{}.rs", module.ident));
            found.take(&path, &parse(&path)?)?;
        }
    }
    found.put_together()
}

fn parse(path: &Path) -> Result<syn::File, ReadError> {
    let text =
        std::fs::read_to_string(path).map_err(|source| ReadError::File { path: path.to_owned(), source })?;
    syn::parse_file(&text).map_err(|source| ReadError::Syntax { path: path.to_owned(), source })
}

impl Found {
    fn take(&mut self, path: &Path, file: &syn::File) -> Result<(), ReadError> {
        for item in &file.items {
            self.take_item(item).map_err(|source| ReadError::Syntax { path: path.to_owned(), source })?;
        }
        Ok(())
    }

    fn take_item(&mut self, item: &Item) -> syn::Result<()> {
        match item {
            Item::Const(constant) if constant.ident != "_" => {
                if let Ok(value) = number(&constant.expr, &self.consts) {
                    self.consts.insert(constant.ident.to_string(), value);
                }
            }
            Item::Struct(structure) => self.structs.push(structure.clone()),
            Item::Macro(call) if call.mac.path.is_ident("assert_layout") => {
                let assertion: Assertion = call.mac.parse_body()?;
                self.assertions.insert(assertion.name.clone(), assertion);
            }
            Item::Macro(call) if call.mac.path.is_ident("wire_codes") => {
                self.codes.push(call.mac.parse_body::<WireCodes>()?.0);
            }
            Item::Impl(block) => self.take_impl(block)?,
            _ => {}
        }
        Ok(())
    }

    /// Service names from `impl Message for T`, bits from `impl T`.
    fn take_impl(&mut self, block: &syn::ItemImpl) -> syn::Result<()> {
        let Type::Path(of) = &*block.self_ty else { return Ok(()) };
        let Some(name) = of.path.get_ident().map(ToString::to_string) else { return Ok(()) };
        let for_message = block.trait_.as_ref().is_some_and(|(_, path, _)| path.is_ident("Message"));
        for item in &block.items {
            let ImplItem::Const(constant) = item else { continue };
            match &constant.expr {
                Expr::Lit(ExprLit { lit: Lit::Str(text), .. })
                    if for_message && constant.ident == "SERVICE" =>
                {
                    self.services.insert(name.clone(), text.value());
                }
                Expr::Lit(ExprLit { lit: Lit::Int(_), .. }) if block.trait_.is_none() => {
                    self.bits.entry(name.clone()).or_default().push(Choice {
                        name: constant.ident.to_string(),
                        doc: doc(&constant.attrs),
                        code: number(&constant.expr, &self.consts)?,
                        label: String::new(),
                    });
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn put_together(self) -> Result<Schema, ReadError> {
        let mut flags = Vec::new();
        let mut waiting = Vec::new();
        for structure in &self.structs {
            let name = structure.ident.to_string();
            if let Some(choices) = self.bits.get(&name) {
                flags.push(Codes { name, doc: doc(&structure.attrs), choices: choices.clone() });
            } else if self.assertions.contains_key(&name) {
                waiting.push(structure);
            }
        }
        let mut sizes = BTreeMap::new();
        let mut structs: Vec<Struct> = Vec::new();
        while !waiting.is_empty() {
            let before = waiting.len();
            let mut later = Vec::new();
            for structure in waiting {
                match self.structure(structure, &sizes)? {
                    Some(known) => {
                        sizes.insert(known.name.clone(), known.size);
                        structs.push(known);
                    }
                    None => later.push(structure),
                }
            }
            if later.len() == before {
                return Err(unfit(&later[0].ident, "holds a structure without `assert_layout!`; assert it"));
            }
            waiting = later;
        }
        let max_obstacles = self.consts.get("MAX_OBSTACLES").copied();
        Ok(Schema {
            max_obstacles: max_obstacles.ok_or_else(|| unfit("MAX_OBSTACLES", "is missing from lib.rs"))?,
            structs,
            codes: self.codes,
            flags,
        })
    }

    /// `None` while a structure it contains is unknown.
    fn structure(
        &self,
        structure: &syn::ItemStruct,
        sizes: &BTreeMap<String, u64>,
    ) -> Result<Option<Struct>, ReadError> {
        let name = structure.ident.to_string();
        let mut fields = Vec::new();
        let mut extents = Vec::new();
        for field in &structure.fields {
            let field_type = self.field_type(&field.ty).ok_or_else(|| {
                unfit(&name, "holds a type other than u32, u64, f64, arrays and structures")
            })?;
            let Some(extent) = layout::size_and_alignment(&field_type, sizes) else { return Ok(None) };
            extents.push(extent);
            let field_name = field.ident.as_ref().map(ToString::to_string).unwrap_or_default();
            fields.push(Field { name: field_name, doc: doc(&field.attrs), field_type, offset: 0 });
        }
        let (offsets, size) = layout::offsets(&extents);
        for (field, offset) in fields.iter_mut().zip(&offsets) {
            field.offset = *offset;
        }
        if extents.iter().map(|(bytes, _)| bytes).sum::<u64>() != size {
            return Err(unfit(&name, "has padding; order its fields so that it has none"));
        }
        let asserted = &self.assertions[&name];
        let stated =
            number(&asserted.size, &self.consts).map_err(|error| unfit(&name, &error.to_string()))?;
        let computed: Vec<_> = fields.iter().map(|field| (field.name.clone(), field.offset)).collect();
        if stated != size || asserted.offsets != computed {
            return Err(unfit(
                &name,
                "is not laid out by the rules of C as `assert_layout!` states; correct the one or the other",
            ));
        }
        let type_name =
            type_name(&structure.attrs).ok_or_else(|| unfit(&name, "has no `#[type_name]`; give it one"))?;
        let service = self.services.get(&name).cloned();
        Ok(Some(Struct { doc: doc(&structure.attrs), name, type_name, service, fields, size }))
    }

    fn field_type(&self, ty: &Type) -> Option<FieldType> {
        match ty {
            Type::Array(array) => {
                let count = number(&array.len, &self.consts).ok()?;
                Some(FieldType::Array(Box::new(self.field_type(&array.elem)?), count))
            }
            Type::Path(path) => {
                let name = path.path.get_ident()?.to_string();
                Some(match name.as_str() {
                    "u32" => FieldType::U32,
                    "u64" => FieldType::U64,
                    "f64" => FieldType::F64,
                    _ if self.assertions.contains_key(&name) => FieldType::Struct(name),
                    _ => return None,
                })
            }
            _ => None,
        }
    }
}

fn unfit(name: &(impl ToString + ?Sized), what: &str) -> ReadError {
    ReadError::Unfit { name: name.to_string(), what: what.to_owned() }
}

/// The lines of `///` above something.
fn doc(attributes: &[Attribute]) -> Vec<String> {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(line), .. }) => Some(line.value()),
            _ => None,
        },
        _ => None,
    });
    lines.map(|line| line.strip_prefix(' ').unwrap_or(&line).to_owned()).collect()
}

/// What `#[type_name("...")]` says.
fn type_name(attributes: &[Attribute]) -> Option<String> {
    let attribute = attributes.iter().find(|attribute| attribute.path().is_ident("type_name"))?;
    attribute.parse_args::<syn::LitStr>().ok().map(|text| text.value())
}
