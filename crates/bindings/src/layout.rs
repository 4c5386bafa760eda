//! Where the fields of a structure lie, by the rules of C.

use std::collections::BTreeMap;

use crate::FieldType;

/// Size and alignment of one field, bytes; `None` if it names an unknown structure. `sizes` holds the structures known so
/// far, all of which are aligned to 8 bytes.
pub(crate) fn size_and_alignment(
    field_type: &FieldType,
    sizes: &BTreeMap<String, u64>,
) -> Option<(u64, u64)> {
    match field_type {
        FieldType::U32 => Some((4, 4)),
        FieldType::U64 | FieldType::F64 => Some((8, 8)),
        FieldType::Struct(name) => sizes.get(name).map(|size| (*size, 8)),
        FieldType::Array(of, count) => {
            size_and_alignment(of, sizes).map(|(size, alignment)| (size * count, alignment))
        }
    }
}

/// Offsets of fields with the given sizes and alignments, and the size of the whole, bytes.
pub(crate) fn offsets(fields: &[(u64, u64)]) -> (Vec<u64>, u64) {
    let (mut end, mut widest, mut offsets) = (0_u64, 1, Vec::new());
    for (size, alignment) in fields {
        let offset = end.next_multiple_of(*alignment);
        offsets.push(offset);
        end = offset + size;
        widest = widest.max(*alignment);
    }
    (offsets, end.next_multiple_of(widest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_field_after_a_narrow_one_leaves_a_gap() {
        assert_eq!(offsets(&[(4, 4), (8, 8), (4, 4)]), (vec![0, 8, 16], 24));
        assert_eq!(offsets(&[(4, 4), (4, 4), (16, 8)]), (vec![0, 4, 8], 24));
    }
}
