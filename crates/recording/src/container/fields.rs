//! Fields of a record. A length is believed only as far as there are bytes.

use std::collections::BTreeMap;

/// Takes fields off the front of a record's bytes; every method answers `None` once they run out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    pub(crate) fn rest(self) -> &'a [u8] {
        self.0
    }

    pub(crate) fn bytes(&mut self, length: u64) -> Option<&'a [u8]> {
        let (head, tail) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = tail;
        Some(head)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, tail) = self.0.split_first_chunk::<N>()?;
        self.0 = tail;
        Some(*head)
    }

    pub(crate) fn byte(&mut self) -> Option<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes behind their 32-bit length.
    pub(crate) fn sized_bytes(&mut self) -> Option<&'a [u8]> {
        let length = self.u32()?;
        self.bytes(u64::from(length))
    }

    pub(crate) fn string(&mut self) -> Option<String> {
        let bytes = self.sized_bytes()?;
        String::from_utf8(bytes.to_vec()).ok()
    }

    pub(crate) fn string_map(&mut self) -> Option<BTreeMap<String, String>> {
        let mut pairs = Fields::new(self.sized_bytes()?);
        let mut map = BTreeMap::new();
        while !pairs.0.is_empty() {
            map.insert(pairs.string()?, pairs.string()?);
        }
        Some(map)
    }
}
