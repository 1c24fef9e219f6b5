a30a5ed038c630c7 {"pliant_session":1,"program":"pliant 0.1.0","scan":"0000000000000005","source":{"phantom":"cube","size":[8,8,8]}}
a7bce124c7300abe {"client":1,"do":"push","point":[1,2,3],"push":[0,1.5,0],"radius":4,"stroke":2,"slide":true}
d8c996d30df93fae {"client":1,"do":"grab","point":[0,0,0],"radius":5}
c1c56a3467530af3 {"count":3,"do":"sweep"}
6513692e99af42df {"client":1,"do":"drag","offset":[0,0.1,0]}
856b8ca82458adcf {"client":1,"do":"let_go"}
cf4a8134b351ec20 {"client":1,"do":"cut","line":[[-5,-5,0.3],[5,-5,0.3]],"depth":[0,10,0]}
60ff3828c13393b0 {"client":1,"do":"carve","from":[8,0,0],"to":[8,0,3],"radius":2,"stroke":1}
75af4677a1695eee {"client":1,"do":"relax","on":true}
4f9fa49fe310294f {"client":1,"do":"release"}
bd6accc2d4eb1c26 {"client":1,"do":"reset"}
10aa38aec48d6848 {"client":1,"do":"materials","offset":0.35,"air_enabled":true,"rounded":false,"yield":0.1}
b9dd889fa0f6c28a {"client":1,"do":"iso","iso_hu":-391.5,"polarity":"falling"}
31d0846f82eaed9a {"client":1,"do":"undo"}
87200eb1a8d6e715 {"do":"mark","tissue":"0000000000000007","volume":