//! Which compiled variant of the network runs. Not here: the variants themselves (`lanes`, `lanes_avx2`,
//! `lanes_avx512`).

use std::fmt;
use std::str::FromStr;

/// One compiled variant of the network's arithmetic.
///
/// [`Kernel::Avx2Fma`] and [`Kernel::Avx512`] give the same bits; [`Kernel::Portable`] agrees with them to about 1e-5
/// but not bit by bit, since a fused multiply-add rounds once. A recording therefore names the variant it was made
/// with, and a byte-exact replay forces the same one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// Plain Rust without fused multiply-add. Runs anywhere, with the same bits everywhere.
    Portable,
    /// Eight lanes of AVX2 with fused multiply-add. x86-64 from about 2013 on.
    Avx2Fma,
    /// Sixteen lanes of AVX-512F.
    Avx512,
}

/// Why a kernel cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum KernelError {
    /// This processor lacks the instructions.
    #[error("this processor cannot run kernel `{kernel}`; use `--kernel portable`, or leave the choice out")]
    Unsupported {
        /// The kernel asked for.
        kernel: Kernel,
    },
    /// No kernel has this name.
    #[error("no kernel is named `{name}`; choose `portable`, `avx2-fma` or `avx512`")]
    Unknown {
        /// The name given.
        name: String,
    },
}

impl Kernel {
    /// Every variant, slowest first.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2Fma, Self::Avx512];

    /// Returns the fastest variant that this processor runs.
    pub fn detect() -> Self {
        Self::ALL.into_iter().rfind(|kernel| kernel.is_supported()).unwrap_or(Self::Portable)
    }

    /// Returns whether this processor runs the variant.
    pub fn is_supported(self) -> bool {
        match self {
            Self::Portable => true,
            #[cfg(target_arch = "x86_64")]
            Self::Avx2Fma => is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => is_x86_feature_detected!("avx512f") && Self::Avx2Fma.is_supported(),
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2Fma | Self::Avx512 => false,
        }
    }

    /// Returns the name that configurations and recordings carry: `portable`, `avx2-fma` or `avx512`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2Fma => "avx2-fma",
            Self::Avx512 => "avx512",
        }
    }
}

impl fmt::Display for Kernel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Kernel {
    type Err = KernelError;

    fn from_str(name: &str) -> Result<Self, KernelError> {
        Self::ALL
            .into_iter()
            .find(|kernel| kernel.name() == name)
            .ok_or_else(|| KernelError::Unknown { name: name.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_leads_back_to_its_kernel() {
        for kernel in Kernel::ALL {
            assert_eq!(kernel.to_string().parse::<Kernel>(), Ok(kernel));
        }
    }

    #[test]
    fn an_unknown_name_is_refused_with_the_names_there_are() {
        let error = "avx9000".parse::<Kernel>().unwrap_err();
        assert!(error.to_string().contains("portable"), "{error}");
    }

    #[test]
    fn the_detected_kernel_runs_here() {
        assert!(Kernel::detect().is_supported());
    }
}
