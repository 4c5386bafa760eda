//! Settings for the unit tests.

use settings::TrainingSettings;

/// A short run that fits the value alone.
pub(crate) fn settings() -> TrainingSettings {
    let text = r#"{ "seed": 3, "epochs": 2, "batch_size": 512, "learning_rate": 8e-3,
        "final_learning_rate": 1e-4, "margin_m": 0.0 }"#;
    serde_json::from_str(text).unwrap()
}
