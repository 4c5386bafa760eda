//! What an input box refuses, in code and in writing. One defect per case.

use dynamics::{InputBox, InputBoxError};

#[test]
fn refuses_empty_and_non_finite_bounds() {
    assert_eq!(
        InputBox::new([0.0, 1.0], [1.0, 0.5]),
        Err(InputBoxError::Empty { component: 1, min: 1.0, max: 0.5 })
    );
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(matches!(InputBox::new([bad], [1.0]), Err(InputBoxError::NonFinite { component: 0, .. })));
        assert!(matches!(InputBox::new([0.0], [bad]), Err(InputBoxError::NonFinite { component: 0, .. })));
    }
    assert!(InputBox::new([0.5], [0.5]).is_ok(), "a single admissible value is a box");
}

#[test]
fn survives_writing_and_refuses_bad_writing() {
    let written = r#"{"min":[0.25,-0.8],"max":[1.0,0.8]}"#;
    let input: InputBox<2> = serde_json::from_str(written).unwrap();
    assert_eq!(serde_json::to_string(&input).unwrap(), written);
    for (defect, hint) in [
        (r#"{"min":[0.25],"max":[1.0,0.8]}"#, "2 inputs"),
        (r#"{"min":[0.25,0.9],"max":[1.0,0.8]}"#, "swap or widen"),
        (r#"{"min":[0.25,-0.8],"max":[1.0,0.8],"mean":[0,0]}"#, "unknown field"),
    ] {
        let message = serde_json::from_str::<InputBox<2>>(defect).unwrap_err().to_string();
        assert!(message.contains(hint), "{message}");
    }
}

#[test]
fn clamps_to_its_faces() {
    let input = InputBox::new([0.25, -0.8], [1.0, 0.8]).unwrap();
    assert_eq!(input.clamp(&[2.0, -3.0]), [1.0, -0.8]);
    assert!(input.contains(&[1.0, 0.8]) && !input.contains(&[1.0, 0.9]));
    assert!(!input.contains(&[f64::NAN, 0.0]));
}
