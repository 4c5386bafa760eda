//! One evaluation of the network, for counting its instructions, which no other load on the machine disturbs:
//!
//! ```text
//! cargo build --release -p barrier --example count
//! valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect='*one_evaluation*' \
//!     target/release/examples/count avx2-fma 20
//! ```
//!
//! Valgrind knows no AVX-512.

use std::hint::black_box;

use barrier::{InputEncoding, Kernel, LayerWeights, NetworkBatch, NetworkWeights, ResidualNetwork};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let [kernel, count] = arguments.as_slice() else {
        return Err("usage: count KERNEL OBSTACLES".into());
    };
    // As many instructions whatever the parameters are.
    let layers = InputEncoding::Raw
        .layer_sizes()
        .windows(2)
        .map(|sizes| LayerWeights { weight: vec![0.01; sizes[0] * sizes[1]], bias: vec![0.1; sizes[1]] })
        .collect();
    let weights = NetworkWeights::new(InputEncoding::Raw, layers)?;
    let mut network = ResidualNetwork::new(&weights, kernel.parse::<Kernel>()?)?;
    let mut batch = NetworkBatch::new();
    batch.set_len(count.parse()?);
    one_evaluation(&mut network, &mut batch);
    println!("{kernel}, {count}: residual {} m", batch.residual(0));
    Ok(())
}

/// What callgrind counts.
#[inline(never)]
fn one_evaluation(network: &mut ResidualNetwork, batch: &mut NetworkBatch) {
    network.evaluate(black_box(batch));
}
