//! Process 2: detections in, obstacle states and their derivatives out.
