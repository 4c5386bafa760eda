//! The two macros of `messages`: stated layouts and wire codes.

use std::collections::BTreeMap;

use syn::{
    Attribute, BinOp, Expr, ExprLit, Ident, Lit, LitInt, LitStr, Token, braced,
    parse::{Parse, ParseStream},
    punctuated::Punctuated,
};

use super::doc;
use crate::{Choice, Codes};

/// `assert_layout!(Name, size, { field: offset, ... })`.
pub(super) struct Assertion {
    pub(super) name: String,
    pub(super) size: Expr,
    /// Fields and their offsets, bytes, in the order in which they stand.
    pub(super) offsets: Vec<(String, u64)>,
}

impl Parse for Assertion {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let name = input.parse::<Ident>()?.to_string();
        input.parse::<Token![,]>()?;
        let size = input.parse()?;
        input.parse::<Token![,]>()?;
        let inside;
        braced!(inside in input);
        let offsets = Punctuated::<Offset, Token![,]>::parse_terminated(&inside)?;
        Ok(Self {
            name,
            size,
            offsets: offsets.into_iter().map(|offset| (offset.field, offset.bytes)).collect(),
        })
    }
}

struct Offset {
    field: String,
    bytes: u64,
}

impl Parse for Offset {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let field = input.parse::<Ident>()?.to_string();
        input.parse::<Token![:]>()?;
        Ok(Self { field, bytes: input.parse::<LitInt>()?.base10_parse()? })
    }
}

/// `wire_codes! { /// doc Name { /// doc Variant = 1 => "label", ... } }`.
pub(super) struct WireCodes(pub(super) Codes);

impl Parse for WireCodes {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let attributes = Attribute::parse_outer(input)?;
        let name = input.parse::<Ident>()?.to_string();
        let inside;
        braced!(inside in input);
        let choices = Punctuated::<Code, Token![,]>::parse_terminated(&inside)?;
        let choices = choices.into_iter().map(|code| code.0).collect();
        Ok(Self(Codes { name, doc: doc(&attributes), choices }))
    }
}

struct Code(Choice);

impl Parse for Code {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let attributes = Attribute::parse_outer(input)?;
        let name = input.parse::<Ident>()?.to_string();
        input.parse::<Token![=]>()?;
        let code = input.parse::<LitInt>()?.base10_parse()?;
        input.parse::<Token![=>]>()?;
        let label = input.parse::<LitStr>()?.value();
        Ok(Self(Choice { name, doc: doc(&attributes), code, label }))
    }
}

/// The value of an expression of integers, named constants, `+` and `*`.
pub(super) fn number(expr: &Expr, consts: &BTreeMap<String, u64>) -> syn::Result<u64> {
    let refuse = || syn::Error::new_spanned(expr, "only integers, constants, + and * are understood");
    match expr {
        Expr::Lit(ExprLit { lit: Lit::Int(literal), .. }) => literal.base10_parse(),
        Expr::Path(path) => {
            let name = path.path.get_ident().ok_or_else(refuse)?.to_string();
            consts.get(&name).copied().ok_or_else(refuse)
        }
        Expr::Binary(binary) => {
            let (left, right) = (number(&binary.left, consts)?, number(&binary.right, consts)?);
            match binary.op {
                BinOp::Add(_) => Ok(left + right),
                BinOp::Mul(_) => Ok(left * right),
                _ => Err(refuse()),
            }
        }
        _ => Err(refuse()),
    }
}
