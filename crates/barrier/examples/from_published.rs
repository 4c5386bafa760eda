//! Makes a model file of weights that come without metadata, such as PyTorch's or those the paper's authors published.
//!
//! `cargo run -p barrier --example from_published -- WEIGHTS.safetensors METADATA.json MODEL.safetensors`
//!
//! The metadata state what the weights were trained for; `quadrotor_published.json` beside this file does so for the
//! authors' quadrotor. `cncbf inspect MODEL.safetensors` then shows them with their hash.

use std::path::Path;

use barrier::{Model, ModelMetadata};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let [weights, metadata, model] = arguments.as_slice() else {
        return Err("usage: from_published WEIGHTS.safetensors METADATA.json MODEL.safetensors".into());
    };
    let metadata: ModelMetadata = serde_json::from_slice(&std::fs::read(metadata)?)?;
    let made = Model::from_published(&std::fs::read(weights)?, metadata)?;
    made.save(Path::new(model))?;
    println!("{model}: {}", made.metadata().hash);
    Ok(())
}
