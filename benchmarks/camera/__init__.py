"""What a camera gives, how long a picture takes to decode, and a replug to the first picture."""
