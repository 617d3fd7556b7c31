"""Changes to a configuration, without a text editor.

`form` lists every key with its meaning, limits and present value, and reads typed text; `in_text`
puts the new values into the configuration's text, `in_file` that text over the one in the file.
"""
