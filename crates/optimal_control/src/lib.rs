//! LQR and SQP over Clarabel.
