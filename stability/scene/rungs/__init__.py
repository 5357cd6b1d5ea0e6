"""Models of a scene, one file each: steady and linear motion, creep, the full model, a user's."""
