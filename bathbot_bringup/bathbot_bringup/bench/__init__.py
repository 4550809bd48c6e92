"""Is this machine fast enough?"""
