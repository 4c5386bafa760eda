//! Social-force pedestrians, robot plants and scenarios.
