"""Changes to a configuration, without a text editor.

``form.py`` makes a form from the configuration's schema: it lists every key with its meaning,
limits and present value, and reads typed text as YAML does. ``in_text.py`` puts the new values into
the configuration's text, where comments and order stay, and refuses a text that it cannot change
rightly. The dashboard's settings use both, in this order.
"""
