//! Compile-time proof that a wire type is laid out as other languages expect.

/// Fails the build if the size of `$ty` or the offset of a field differs from what is written here.
macro_rules! assert_layout {
    ($ty:ty, $size:expr, { $($field:ident : $offset:expr),+ $(,)? }) => {
        const _: () = {
            assert!(core::mem::size_of::<$ty>() == $size, "size changed: bump the version in the type name");
            assert!(core::mem::align_of::<$ty>() == 8, "alignment changed: bump the version in the type name");
            $(assert!(
                core::mem::offset_of!($ty, $field) == $offset,
                "a field moved: bump the version in the type name"
            );)+
        };
    };
}

pub(crate) use assert_layout;
