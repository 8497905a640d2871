"""Rooms from point clouds, with dimensions that can be believed."""
