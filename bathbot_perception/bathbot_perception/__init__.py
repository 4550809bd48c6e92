"""Skin regions in a colour picture: a YOLOv5s detector, its training and its tests."""
